// Where the map acts: masks, and fixed and sliding faces. Each limit multiplies the displacement, or
// the part of it that is normal to a face, by a factor from 0 to 1.
//
// Build constant: AT_REST.

#include "images.cl"

// The factor of a limit at a point, its slope, and for a sliding face its normal and the slopes of that.
typedef struct {
  real factor;
  vec slope, normal;
  mat turn;
} limit_at_t;

// From 0 to 1 with two continuous derivatives, exactly 0 up to t = 0 and 1 from t = 1 on.
inline real fade(real t, real *slope) {
  t = clamp01(t);
  *slope = 30 * t * t * (1 - t) * (1 - t);
  return t * t * t * fma(t, fma((real)(6), t, (real)(-15)), (real)(10));
}

inline limit_at_t mask_of_box(__global const limit_t *limit, vec v) {
  const vec low = load3(limit->low), high = load3(limit->high);
  const vec off = {v.x - fast_min(fast_max(v.x, low.x), high.x),
                   v.y - fast_min(fast_max(v.y, low.y), high.y),
                   v.z - fast_min(fast_max(v.z, low.z), high.z)};
  const real length = sqrt(dot3(off, off));
  limit_at_t at;
  real slope;
  at.factor = 1 - fade((length - limit->radius) / limit->falloff, &slope);
  at.slope = vec_scale(-slope / (limit->falloff * fast_max(length, (real)(1e-30f))), off);
  return at;
}

// As a fraction of a spacing: so that the outer points of the image are inside of it to rounding.
#define MASK_EDGE ((real)(1e-3f))

inline limit_at_t mask_of_image(__global const limit_t *limit, __global const float *images, vec v) {
  vec beyond, steps;
  const vec index =
      limited_index(last_index(limit->size), index_in_image(limit->to_index, v), &beyond);
  const image_cell_t cell = image_cell(limit->size, index);
  const integer outside = (fabs(beyond.x) > MASK_EDGE) | (fabs(beyond.y) > MASK_EDGE) |
                          (fabs(beyond.z) > MASK_EDGE);
  limit_at_t at;
  at.factor = image_value(images + limit->first, limit->size, cell, &steps);
  at.factor = select(at.factor, (real)(0), outside);
  const vec none = {0, 0, 0};
  at.slope = vec_select(by_index(limit->to_index, steps), none, outside);
  return at;
}

inline limit_at_t face_of_plane(__global const limit_t *limit, vec v) {
  limit_at_t at;
  at.normal = load3(limit->low);
  const real height = dot3(at.normal, v) + limit->high[0];
  real slope;
  at.factor = fade(fabs(height) / limit->falloff, &slope);
  at.slope = vec_scale(copysign(slope, height) / limit->falloff, at.normal);
  at.turn = (mat){{0}};
  return at;
}

inline limit_at_t face_of_image(__global const limit_t *limit, __global const float *images, vec v) {
  vec beyond;
  const vec index =
      limited_index(last_index(limit->size), index_in_image(limit->to_index, v), &beyond);
  const integer outside = (beyond.x != 0) | (beyond.y != 0) | (beyond.z != 0);
  const image_cell_t cell = image_cell(limit->size, index);
  const distance_t distance = distance_at(images + limit->first, limit->size, cell);
  const vec none = {0, 0, 0};
  limit_at_t at;
  real slope;
  at.factor = fade(distance.value / limit->falloff, &slope);
  at.factor = select(at.factor, (real)(1), outside);
  at.slope = vec_scale(slope / limit->falloff, by_index(limit->to_index, distance.slope));
  at.slope = vec_select(at.slope, none, outside);
  at.normal = distance.normal;
  for (int i = 0; i < 3; ++i)
    set_mat_row(&at.turn, i, by_index(limit->to_index, mat_row(&distance.turn, i)));
  return at;
}

inline limit_at_t limit_at(__global const limit_t *limit, __global const float *images, vec v) {
  if (limit->form == BOX_MASK) return mask_of_box(limit, v);
  if (limit->form == IMAGE_MASK) return mask_of_image(limit, images, v);
  if (limit->form == PLANE_FACE) return face_of_plane(limit, v);
  return face_of_image(limit, images, v);
}

// The displacement d at v after all limits.
inline vec limited(const map_t *map, vec v, vec d) {
  for (int i = 0; i < map->params.limit_count; ++i) {
    __global const limit_t *limit = map->limits + i;
    const limit_at_t at = limit_at(limit, map->images, v);
    if (limit->slides)
      d = vec_madd(-(1 - at.factor) * dot3(at.normal, d), at.normal, d);
    else
      d = vec_scale(at.factor, d);
  }
  return d;
}

// Takes the part of the derivatives j along the normal away, times `share`.
inline void slide(mat *j, vec normal, real share) {
  for (int column = 0; column < 3; ++column) {
    const vec d = mat_column(j, column);
    set_mat_column(j, column, vec_madd(-share * dot3(normal, d), normal, d));
  }
}

// The derivatives after all limits, for the displacement d at v before them.
inline weight_jacobian_t limited_jacobian(const map_t *map, vec v, vec d,
                                          weight_jacobian_t jacobian) {
  for (int i = 0; i < map->params.limit_count; ++i) {
    __global const limit_t *limit = map->limits + i;
    const limit_at_t at = limit_at(limit, map->images, v);
    const real share = 1 - at.factor, along = dot3(at.normal, d);
    if (limit->slides) {
      slide(&jacobian.d_dv, at.normal, share);
      if (AT_REST) slide(&jacobian.d_dx, at.normal, share);
      // the normal turns as v moves
      vec turned = vec_scale(-share, transposed_mat_vec(&at.turn, d));
      turned = vec_madd(along, at.slope, turned);
      add_outer(&jacobian.d_dv, at.normal, turned);
      for (int n = 0; n < 9; ++n)
        jacobian.d_dv.a[n] = fma(-share * along, at.turn.a[n], jacobian.d_dv.a[n]);
      d = vec_madd(-share * along, at.normal, d);
    } else {
      for (int n = 0; n < 9; ++n) jacobian.d_dv.a[n] *= at.factor;
      add_outer(&jacobian.d_dv, d, at.slope);
      for (int n = 0; AT_REST && n < 9; ++n) jacobian.d_dx.a[n] *= at.factor;
      d = vec_scale(at.factor, d);
    }
  }
  return jacobian;
}
