// Rigid regions: control points, the proxies of a region, share the distance from it as their own.

// Squared distance inside of regions: a control point there has the larger weight.
#define IN_REGION 1e-20f

// A squared distance from a region, and half its gradient.
typedef struct { real square; vec away; } region_distance_t;

inline region_distance_t distance_from_capsule(__global const region_t *region, vec v) {
  const vec along = {region->along[0], region->along[1], region->along[2]};
  const vec to = {v.x - region->end[0], v.y - region->end[1], v.z - region->end[2]};
  const real share = dot3(to, along) / most(dot3(along, along), (real)(1e-30f));
  const vec off = vec_madd(-least(most(share, (real)(0)), (real)(1)), along, to);
  const real length = sqrt(dot3(off, off));
  const real distance = most(length - region->radius, (real)(0));
  return (region_distance_t){distance * distance,
                             vec_scale(distance / most(length, (real)(1e-30f)), off)};
}

// Beyond the image the distance is that from the place on the shape closest to the image's border: the
// square of |beyond + value normal|, of a unit normal. The normals follow the distances.
inline region_distance_t distance_in_image(__global const region_t *region,
                                           __global const float *images, vec v) {
  vec beyond, slope;
  const vec index = limited_index(region->size, index_in_image(region->to_index, v), &beyond);
  __global const float *values = images + region->first;
  const real value = most(image_value(values, region->size, index, &slope), (real)(0));
  real square = value * value;
  vec toward = vec_scale(value, slope);
  const integer outside = (beyond.x != 0) | (beyond.y != 0) | (beyond.z != 0);
  if (ANY(outside)) {
    const int count = region->size[0] * region->size[1] * region->size[2];
    vec turn[3];
    const vec normal = {image_value(values + count, region->size, index, turn),
                        image_value(values + 2 * count, region->size, index, turn + 1),
                        image_value(values + 3 * count, region->size, index, turn + 2)};
    const real along = dot3(beyond, normal);
    vec inner = vec_scale(value + along, slope), outer = vec_madd(value, normal, beyond);
    inner = vec_madd(value * beyond.x, turn[0], inner);
    inner = vec_madd(value * beyond.y, turn[1], inner);
    inner = vec_madd(value * beyond.z, turn[2], inner);
    outer = (vec){select(inner.x, outer.x, beyond.x != 0), select(inner.y, outer.y, beyond.y != 0),
                  select(inner.z, outer.z, beyond.z != 0)};
    square = select(square, fma(2 * value, along, square) + dot3(beyond, beyond), outside);
    toward = vec_select(toward, outer, outside);
  }
  return (region_distance_t){region->step * region->step * square,
                             from_steps(region->to_index, region->step, toward)};
}

inline region_distance_t distance_from_region(__global const region_t *region,
                                              __global const float *images, vec v) {
  region_distance_t distance;
  if (region->step > 0)
    distance = distance_in_image(region, images, v);
  else
    distance = distance_from_capsule(region, v);
  distance.square = most(distance.square, (real)(IN_REGION));
  return distance;
}
