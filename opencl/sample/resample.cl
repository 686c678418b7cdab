// Values of an array at continuous indices, as vtk_mls/base/interpolation.py computes them.

#include "types.cl"
#include "sums.cl"
#include "taps.cl"
#include "values.cl"

#if SAMPLE_TAPS == 2
#include "linear.cl"
#elif SAMPLE_TAPS == 4
#include "cubic.cl"
#endif

#if SAMPLE_TAPS > 1
#if !IS_INTEGER
// The sum of the taps with weight of lane l, one after the other.
inline SUM weighted_sum(const box_t *box, const offsets_t *at, const int is_whole,
                        __global const VALUE *values, int l) {
  SUM sum = 0;
  for (int k = 0; k < SAMPLE_TAPS; ++k)
    for (int j = 0; j < SAMPLE_TAPS; ++j)
      for (int i = 0; i < SAMPLE_TAPS; ++i) {
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
#if !IS_INTEGER
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

// Values that a work item stores, of `lanes` points.
typedef struct {
  __global VALUE *to;
  int lanes, components;
} output_t;

HOT void set_component(const output_t *output, int c, VALUES sampled) {
  __global VALUE *to = output->to + c;
  if (output->components == 1 && output->lanes == LANES) {
    STORE(sampled, to);
    return;
  }
  for (int l = 0; l < output->lanes; ++l) to[l * output->components] = LANE_VALUE(sampled, l);
}

// Replaces values `on_point` by those of the nearest points, to the bit, and others than `inside`
// by the background.
HOT VALUES with_exact(VALUES sampled, __global const VALUE *values, offset_t nearest,
                      integer on_point, integer inside, __global const VALUE *background) {
  UNROLL_ALL for (int l = 0; l < LANES; ++l) {
    if (LANE_INT(on_point, l)) LANE_VALUE(sampled, l) = values[LANE_OFFSET(nearest, l)];
    if (!LANE_INT(inside, l)) LANE_VALUE(sampled, l) = *background;
  }
  return sampled;
}

#if SAMPLE_TAPS == 1
HOT void sample_nearest(output_t *output, const axes_t *axes, vec at,
                        __global const VALUE *values, __global const VALUE *background) {
  const offset_t nearest = nearest_offset(axes, at);
  const integer inside = are_inside(axes, at), all = (real)(0) == 0;
  for (int c = 0; c < output->components; ++c)
    set_component(output, c,
                  with_exact((VALUES)(0), values + c, nearest, all, inside, background + c));
}
#else
// Values in boxes that are whole, as almost everywhere.
HOT void sample_whole(output_t *output, const axes_t *axes, const box_t *box, vec at,
                      __global const VALUE *values) {
  offsets_t taps;
  taps.corner = offset_of(axes, box->x.first, box->y.first, box->z.first);
#if HAS_PIVOT
  taps.nearest = nearest_offset(axes, at);
#endif
  if (output->components == 1) {  // compilers make this case faster
    set_component(output, 0, value_in(box, &taps, 1, values));
    return;
  }
  for (int c = 0; c < output->components; ++c)
    set_component(output, c, value_in(box, &taps, 1, values + c));
}

// Values at a border, on grid points and outside.
HOT void sample_parts(output_t *output, const axes_t *axes, const box_t *box, vec at,
                      __global const VALUE *values, __global const VALUE *background) {
  const offsets_t taps = offsets_in(box, axes, at);
  const integer on_point = (box->x.behind == 0) & (box->y.behind == 0) & (box->z.behind == 0);
  const integer inside = are_inside(axes, at);
  for (int c = 0; c < output->components; ++c) {
    const VALUES sampled = value_in(box, &taps, 0, values + c);
    set_component(
        output, c, with_exact(sampled, values + c, taps.nearest, on_point, inside, background + c));
  }
}
#endif

// `index` holds three planes of `count` indices, `background` a value for each component.
__kernel EXPLICIT_VECTORS void resample(
    const long count, __global const float *restrict index, const array_t array,
    __global const VALUE *restrict background, __global const VALUE *restrict values,
    __global VALUE *restrict result) {
  const long first = (long)get_global_id(0) * LANES;
  if (first >= count) return;
  const int components = array.components;
  output_t output = {result + first * components, (int)min((long)LANES, count - first), components};
  const axes_t axes = axes_of(&array, components);
  const vec at = load_points(index, count, first);
#if SAMPLE_TAPS == 1
  sample_nearest(&output, &axes, at, values, background);
#else
  box_t box;
  if (ALL(find_box(&box, &axes, at)))
    sample_whole(&output, &axes, &box, at, values);
  else
    sample_parts(&output, &axes, &box, at, values, background);
#endif
}
