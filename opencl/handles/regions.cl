// Rigid regions: control points, the proxies of a region, share the distance from it as their own.

#include "images.cl"

// Squared distance inside of regions: a control point there has the larger weight.
#define IN_REGION 1e-20f

// A squared distance from a region, and half its gradient.
typedef struct { real square; vec outward; } region_distance_t;

inline region_distance_t distance_from_capsule(__global const region_t *region, vec v) {
  const vec along = load3(region->along), to = vec_sub(v, load3(region->end));
  const real share = dot3(to, along) / fast_max(dot3(along, along), (real)(1e-30f));
  const vec off = vec_madd(-clamp01(share), along, to);
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

// a >= 0 without its fraction.
inline real whole(real a) { return TO_REAL(TO_INTEGER(a)); }

// The place is on a face of the image: across x if the index is limited along x, else across y or z.
// The border has the faces across x, y and z, the lower one first, all with as many rows of one length;
// the rows are along x, or along y across x.
HOT border_t on_border(__global const region_t *region, __global const float *border, vec last,
                       vec index, vec beyond, const int with_slopes) {
  const integer across_x = beyond.x != 0, across_y = beyond.y != 0,
                has_z = across_x | across_y;  // whether z is along the face
  const real a = select(index.x, index.y, across_x), b = select(index.y, index.z, has_z);
  const real outward = select(select(beyond.z, beyond.y, across_y), beyond.x, across_x);
  const real column = fast_min(whole(a), select(last.x, last.y, across_x) - 1),
             row = fast_min(whole(b), select(last.y, last.z, has_z) - 1);
  const real face = region->face;
  real first = select(select(4 * face, 2 * face, across_y), (real)(0), across_x);
  first += select((real)(0), face, outward > 0);
  first = fma(row, (real)(region->row), fma(column, (real)(4), first));
  quad_t c0[QUADS], c1[QUADS], x0[QUADS], x1[QUADS], share_a[QUADS], share_b[QUADS];
  const integer corner = TO_INTEGER(first);
  load_two_quads(border, corner, c0, x0);
  load_two_quads(border + (int)(region->row), corner, c1, x1);
  to_quads(a - column, share_a);
  to_quads(b - row, share_b);
  quad_t value[QUADS], along[QUADS], up[QUADS];
  UNROLL_ALL for (int l = 0; l < QUADS; ++l) {
    x0[l] -= c0[l];
    x1[l] -= c1[l];
    const quad_t low = fma(share_a[l], x0[l], c0[l]), high = fma(share_a[l], x1[l], c1[l]);
    up[l] = high - low;
    value[l] = fma(share_b[l], up[l], low);
    along[l] = fma(share_b[l], x1[l] - x0[l], x0[l]);
  }
  border_t at;
  real values[4];
  from_quads(value, values);
  at.value = values[0];
  at.normal = (vec){values[1], values[2], values[3]};
  if (with_slopes) {
    real by_a[4], by_b[4];
    from_quads(along, by_a);
    from_quads(up, by_b);
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
                                        __global const float *images, vec v,
                                        const int with_outward) {
  vec beyond;
  const vec last = load3(region->last);
  const vec index = limited_index(last, index_in_image(region->to_index, v), &beyond);
  const integer is_beyond = (beyond.x != 0) | (beyond.y != 0) | (beyond.z != 0);
  region_distance_t distance = {0, {0, 0, 0}};
  if (!ALL(is_beyond)) {
    vec slope;
    const image_cell_t cell = image_cell(region->size, index);
    real value = image_value(images + region->first, region->size, cell, &slope);
    value = fast_max(value, (real)(0));
    distance.square = value * value;
    distance.outward = vec_scale(value, slope);
  }
  if (ANY(is_beyond)) {
    const border_t at =
        on_border(region, images + region->border, last, index, beyond, with_outward);
    const real value = fast_max(at.value, (real)(0)), along = dot3(beyond, at.normal);
    const real square = fma(2 * value, along, fma(value, value, dot3(beyond, beyond)));
    distance.square = select(distance.square, square, is_beyond);
    if (with_outward) {
      // half the gradient: along axes on which the index is limited, and along others
      const vec outer = vec_madd(value, at.normal, beyond);
      const vec inner = vec_madd(value, at.turned, vec_scale(value + along, at.slope));
      const vec outward = {select(inner.x, outer.x, beyond.x != 0),
                        select(inner.y, outer.y, beyond.y != 0),
                        select(inner.z, outer.z, beyond.z != 0)};
      distance.outward = vec_select(distance.outward, outward, is_beyond);
    }
  }
  // from index steps, which have one length in all directions, to the local frame
  const float step2 = region->step * region->step;
  distance.square *= step2;
  if (with_outward)
    distance.outward = vec_scale((real)(step2), by_index(region->to_index, distance.outward));
  return distance;
}

// The distance from a region; half its gradient only `with_outward`.
HOT region_distance_t distance_from_region(__global const region_t *region,
                                           __global const float *images, vec v,
                                           const int with_outward) {
  region_distance_t distance;
  if (region->step > 0)
    distance = distance_in_image(region, images, v, with_outward);
  else
    distance = distance_from_capsule(region, v);
  distance.square = fast_max(distance.square, (real)(IN_REGION));
  return distance;
}
