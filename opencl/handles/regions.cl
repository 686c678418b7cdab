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

// The distance and the normal on the border of an image, at the place closest to v.
typedef struct {
  real value;
  vec normal;
  vec slope;  // the changes per step of the value, and of the normal's part along `beyond`
  vec turned;
} border_t;

// The place is on a face of the image: across x if the index is limited along x, else across y or z.
// The faces follow the distances: of x, y and z, the lower one first. Their rows are along x, or y.
HOT border_t on_border(__global const float *faces, __global const int *size, vec index, vec beyond,
                       const int with_slopes) {
  const integer across_x = beyond.x != 0, across_y = !across_x & (beyond.y != 0),
                across_z = !across_x & !across_y;
  const real a = select(index.x, index.y, across_x), b = select(index.z, index.y, across_z);
  const real outward = select(select(beyond.z, beyond.y, across_y), beyond.x, across_x);
  const integer columns = select((integer)(size[0]), (integer)(size[1]), across_x);
  const integer rows = select((integer)(size[2]), (integer)(size[1]), across_z);
  const integer i = clamp(TO_INTEGER(a), (integer)(0), columns - 2),
                j = clamp(TO_INTEGER(b), (integer)(0), rows - 2);
  const int face_x = size[1] * size[2], face_y = size[0] * size[2];
  integer first = select((integer)(2 * face_x), (integer)(0), across_x);
  first = select(first, (integer)(2 * (face_x + face_y)), across_z);
  first += select((integer)(0), columns * rows, outward > 0) + i + columns * j;
  const real share_a = a - TO_REAL(i), share_b = b - TO_REAL(j);
  real by_a[4], by_b[4];
  border_t at;
  for (int l = 0; l < LANES; ++l) {
    const int row = LANE_INT(columns, l);
    __global const float *corner = faces + 4 * LANE_INT(first, l);
    const float4 c0 = vload4(0, corner), c1 = vload4(row, corner);
    const float4 x0 = vload4(1, corner) - c0, x1 = vload4(row + 1, corner) - c1;
    const float4 low = c0 + LANE(share_a, l) * x0, high = c1 + LANE(share_a, l) * x1;
    const float4 value = low + LANE(share_b, l) * (high - low);
    LANE(at.value, l) = value.x;
    LANE(at.normal.x, l) = value.y;
    LANE(at.normal.y, l) = value.z;
    LANE(at.normal.z, l) = value.w;
    if (!with_slopes) continue;
    const float4 along = x0 + LANE(share_b, l) * (x1 - x0), up = high - low;
    const float of_a[4] = {along.x, along.y, along.z, along.w}, of_b[4] = {up.x, up.y, up.z, up.w};
    for (int n = 0; n < 4; ++n) {
      LANE(by_a[n], l) = of_a[n];
      LANE(by_b[n], l) = of_b[n];
    }
  }
  if (with_slopes) {
    const real turned_a = dot3((vec){by_a[1], by_a[2], by_a[3]}, beyond),
               turned_b = dot3((vec){by_b[1], by_b[2], by_b[3]}, beyond);
    // the values across the face are not used
    at.slope = (vec){by_a[0], select(by_b[0], by_a[0], across_x), by_b[0]};
    at.turned = (vec){turned_a, select(turned_b, turned_a, across_x), turned_b};
  }
  return at;
}

// Beyond the image the distance is that from the place on the shape closest to the image's border: the
// square of |beyond + value normal|, of a unit normal.
HOT region_distance_t distance_in_image(__global const region_t *region,
                                        __global const float *images, vec v, const int with_away) {
  vec beyond;
  const vec index = limited_index(region->size, index_in_image(region->to_index, v), &beyond);
  const integer is_beyond = (beyond.x != 0) | (beyond.y != 0) | (beyond.z != 0);
  __global const float *values = images + region->first;
  region_distance_t distance = {0, {0, 0, 0}};
  if (!ALL(is_beyond)) {
    vec slope;
    const image_cell_t cell = image_cell(region->size, index);
    const real value = fast_max(image_value(values, region->size, cell, &slope), (real)(0));
    distance.square = value * value;
    distance.away = vec_scale(value, slope);
  }
  if (ANY(is_beyond)) {
    __global const float *faces = values + region->size[0] * region->size[1] * region->size[2];
    const border_t at = on_border(faces, region->size, index, beyond, with_away);
    const real value = fast_max(at.value, (real)(0)), along = dot3(beyond, at.normal);
    const real square = fma(2 * value, along, fma(value, value, dot3(beyond, beyond)));
    distance.square = select(distance.square, square, is_beyond);
    if (with_away) {
      // half the gradient: along axes on which the index is limited, and along others
      const vec outer = vec_madd(value, at.normal, beyond);
      const vec inner = vec_madd(value, at.turned, vec_scale(value + along, at.slope));
      const vec away = {select(inner.x, outer.x, beyond.x != 0),
                        select(inner.y, outer.y, beyond.y != 0),
                        select(inner.z, outer.z, beyond.z != 0)};
      distance.away = vec_select(distance.away, away, is_beyond);
    }
  }
  distance.square *= region->step * region->step;
  if (with_away) distance.away = from_steps(region->to_index, region->step, distance.away);
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
