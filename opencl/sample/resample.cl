// Values of an array at continuous indices, as vtk_mls/base/interpolation.py computes them.

#include "types.cl"
#include "sums.cl"
#include "taps.cl"
#include "values.cl"

#if TAPS == 2
#include "linear.cl"
#elif TAPS == 4
#include "cubic.cl"
#endif

#if TAPS > 1
#if HAS_INFINITY
// The sum of the taps with weight of lane l, one after the other.
inline SUM weighted_sum(const box_t *box, const offsets_t *at, const int is_whole,
                        __global const VALUE *values, int l) {
  SUM sum = 0;
  for (int k = 0; k < TAPS; ++k)
    for (int j = 0; j < TAPS; ++j)
      for (int i = 0; i < TAPS; ++i) {
        const SUM weight = LANE_SUM(box->x.weight[i], l) * LANE_SUM(box->y.weight[j], l) *
                           LANE_SUM(box->z.weight[k], l);
        const OFFSET from =
            is_whole ? LANE_OFFSET(at->corner, l) + k * box->step_z + j * box->step_y +
                           i * box->step_x
                     : LANE_OFFSET(at->z[k], l) + LANE_OFFSET(at->y[j], l) +
                           LANE_OFFSET(at->x[i], l);
        if (weight != 0) sum = fma(weight, (SUM)values[from], sum);
      }
  return sum;
}
#endif

// The value of a box of taps, in the type of the array.
HOT VALUES value_in(const box_t *box, const offsets_t *at, const int is_whole,
                    __global const VALUE *values) {
#if HAS_PIVOT
  const tap_t pivot = gathered(values, at->nearest);
#else
  const tap_t pivot = 0;  // not used
#endif
  sum_t sum = interpolated(box, at, is_whole, values, pivot);
#if IS_INTEGER64
  return rounded_sum(pivot, sum);
#else
#if HAS_PIVOT
  sum += pivot;
#endif
#if HAS_INFINITY
  // 0 times infinity is NaN, and differences of finite values may be infinite. Copies: the compiler
  // keeps variables in memory whose address a loop uses.
  if ((HAS_PIVOT || !is_whole) && !ALL(TO_INTEGER(isfinite(sum)))) {
    const box_t taps = *box;
    const offsets_t offsets = *at;
    for (int l = 0; l < LANES; ++l)
      if (!isfinite(LANE_SUM(sum, l)))
        LANE_SUM(sum, l) = weighted_sum(&taps, &offsets, is_whole, values, l);
  }
#endif
  return CAST(sum);
#endif
}
#endif

inline void store_values(__global VALUE *to, VALUES sampled, int lanes, int components) {
  if (components == 1 && lanes == LANES) {
    STORE(sampled, to);
    return;
  }
  for (int l = 0; l < lanes; ++l) to[l * components] = LANE_VALUE(sampled, l);
}

// COVARIANT is a constant: with three components at compile time, vectors take 2 % less time.
#if COVARIANT
// J^T n (Eq. 29) of vectors n; of length 1 (or 0) if `normalize`. After the three planes of indices
// `grid_source_frame` stores nine of J = dG/dv.
inline vec covariant(vec n, int normalize, __global const float *index, long count, long first) {
  mat j;
  for (int i = 0; i < 9; ++i) j.a[i] = load_plane(index + (3 + i) * count, count, first);
  n = transposed_mat_vec(&j, n);
  return normalize ? unit3(n) : n;
}
#endif

// `index` holds three planes of `count` indices; `normalize` is for covariant vectors.
__kernel EXPLICIT_VECTORS void resample(
    const long count, __global const float *restrict index, const array_t array,
    const VALUE background, const int normalize, __global const VALUE *restrict values,
    __global VALUE *restrict result) {
  long first = (long)get_global_id(0) * LANES;
  if (first >= count) return;
  const int lanes = (int)min((long)LANES, count - first);
#if COVARIANT
  const int components = 3;
#else
  const int components = array.components;
#endif
  const OFFSET line = (OFFSET)array.stored[0] * components, slice = line * array.stored[1];
  const axis_t x = {array.size[0], array.first[0], array.stored[0], components};
  const axis_t y = {array.size[1], array.first[1], array.stored[1], line};
  const axis_t z = {array.size[2], array.first[2], array.stored[2], slice};
  const vec at = load_points(index, count, first);
  __global VALUE *to = result + first * components;
#if COVARIANT
  real vectors[3];
#define SET_COMPONENT(c, values) vectors[c] = values
#define STORE_COMPONENTS                                                                          \
  store_interleaved(                                                                              \
      to, covariant((vec){vectors[0], vectors[1], vectors[2]}, normalize, index, count, first),   \
      lanes)
#else
#define SET_COMPONENT(c, values) store_values(to + (c), values, lanes, components)
#define STORE_COMPONENTS
#endif
#if TAPS > 1
  box_t box = {.step_x = x.step, .step_y = y.step, .step_z = z.step};
  offsets_t at_taps;
  const integer whole = find_taps(&box.x, &x, at.x) & find_taps(&box.y, &y, at.y) &
                        find_taps(&box.z, &z, at.z);
  if (ALL(whole)) {  // as almost everywhere
    at_taps.corner = TO_OFFSET(box.z.first) * z.step + TO_OFFSET(box.y.first) * y.step +
                    TO_OFFSET(box.x.first) * x.step;
#if HAS_PIVOT
    at_taps.nearest = TO_OFFSET(nearest_to(&z, at.z)) * z.step +
                      TO_OFFSET(nearest_to(&y, at.y)) * y.step +
                      TO_OFFSET(nearest_to(&x, at.x)) * x.step;
#endif
#if COVARIANT && TAPS == 2 && LANES > 1
    // not for the last vector, which ends at the end of the array
    if (ALL(at_taps.corner < slice * array.stored[2] - (slice + line + 6))) {
      const vec n = interpolated_three(&box, &at_taps, values);
      store_interleaved(to, covariant(n, normalize, index, count, first), lanes);
      return;
    }
#elif !COVARIANT
    if (components == 1) {  // compilers make this case faster
      SET_COMPONENT(0, value_in(&box, &at_taps, 1, values));
      return;
    }
#endif
    for (int c = 0; c < components; ++c) SET_COMPONENT(c, value_in(&box, &at_taps, 1, values + c));
    STORE_COMPONENTS;
    return;
  }
#endif
  const integer inside = is_inside(&x, at.x) & is_inside(&y, at.y) & is_inside(&z, at.z);
  const integer nearest_x = nearest_to(&x, at.x), nearest_y = nearest_to(&y, at.y),
                nearest_z = nearest_to(&z, at.z);
  const offset_t nearest = TO_OFFSET(nearest_z) * z.step + TO_OFFSET(nearest_y) * y.step +
                           TO_OFFSET(nearest_x) * x.step;
#if TAPS > 1
  at_taps.nearest = nearest;
  tap_offsets(at_taps.x, &box.x, &x, nearest_x);
  tap_offsets(at_taps.y, &box.y, &y, nearest_y);
  tap_offsets(at_taps.z, &box.z, &z, nearest_z);
  const integer on_point = (box.x.behind == 0) & (box.y.behind == 0) & (box.z.behind == 0);
#endif
  for (int c = 0; c < components; ++c) {
    VALUES sampled;
#if TAPS > 1
    sampled = value_in(&box, &at_taps, 0, values + c);
#endif
    UNROLL for (int l = 0; l < LANES; ++l) {
#if TAPS > 1
      if (LANE_INT(on_point, l))  // to the bit
#endif
        LANE_VALUE(sampled, l) = values[LANE_OFFSET(nearest, l) + c];
      if (!LANE_INT(inside, l)) LANE_VALUE(sampled, l) = background;
    }
    SET_COMPONENT(c, sampled);
  }
  STORE_COMPONENTS;
}
