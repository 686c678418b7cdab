// Rigid regions: control points, the proxies of a region, share the distance from it as their own.

// Squared distance inside of regions: a control point there has the larger weight.
#define IN_REGION 1e-20f

// A squared distance from a region, and half its gradient.
typedef struct { real square; vec away; } region_distance_t;

inline region_distance_t distance_from_capsule(__global const region_t *region, vec v) {
  const vec along = {region->along[0], region->along[1], region->along[2]};
  const vec to = {v.x - region->end[0], v.y - region->end[1], v.z - region->end[2]};
  const real share = dot3(to, along) / fast_max(dot3(along, along), (real)(1e-30f));
  const vec off = vec_madd(-fast_min(fast_max(share, (real)(0)), (real)(1)), along, to);
  const real length = sqrt(dot3(off, off));
  const real distance = fast_max(length - region->radius, (real)(0));
  return (region_distance_t){distance * distance,
                             vec_scale(distance / fast_max(length, (real)(1e-30f)), off)};
}

// Beyond the image the distance is that from the place on the shape closest to the image's border: the
// square of |beyond + value normal|, of a unit normal.
HOT region_distance_t distance_in_image(__global const region_t *region,
                                        __global const float *images, vec v, const int with_away) {
  vec beyond;
  const vec index = limited_index(region->size, index_in_image(region->to_index, v), &beyond);
  const image_cell_t cell = image_cell(region->size, index);
  const distance_t at = distance_at(images + region->first, region->size, cell, with_away);
  const real value = fast_max(at.value, (real)(0)), along = dot3(beyond, at.normal);
  const real step2 = region->step * region->step;
  region_distance_t distance;
  distance.square = step2 * fma(2 * value, along, fma(value, value, dot3(beyond, beyond)));
  if (with_away) {
    // half the gradient: along axes on which the index is limited, and along others
    const vec outer = vec_madd(value, at.normal, beyond);
    vec away = vec_scale(value + along, at.slope);
    away = vec_madd(value, transposed_mat_vec(&at.turn, beyond), away);
    away = (vec){select(away.x, outer.x, beyond.x != 0), select(away.y, outer.y, beyond.y != 0),
                 select(away.z, outer.z, beyond.z != 0)};
    distance.away = from_steps(region->to_index, region->step, away);
  }
  return distance;
}

// The distance from a region; half its gradient only `with_away`.
HOT region_distance_t distance_from_region(__global const region_t *region,
                                           __global const float *images, vec v,
                                           const int with_away) {
  region_distance_t distance;
  if (region->step > 0)
    distance = distance_in_image(region, images, v, with_away);
  else
    distance = distance_from_capsule(region, v);
  distance.square = fast_max(distance.square, (real)(IN_REGION));
  return distance;
}
