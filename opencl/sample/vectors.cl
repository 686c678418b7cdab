// Vectors at continuous indices of an array of three floats per point, interpolated as in resample.cl;
// 0 outside.

#define HAS_VECTORS 1

#ifndef SUM  // a fit may have included it
#include "sums.cl"
#endif
#include "taps.cl"

#if SAMPLE_TAPS == 1
inline vec vectors_at(const array_t *array, __global const float *values, vec at) {
  const axes_t axes = axes_of(array, 3);
  const offset_t nearest = nearest_offset(&axes, at);
  vec result;
  for (int l = 0; l < LANES; ++l)
    set_lane(&result, l, vload3(0, values + LANE_OFFSET(nearest, l)));
  return vec_select((vec){0, 0, 0}, result, are_inside(&axes, at));
}
#else
#define TAP_WEIGHT(axis, tap, l) ((float)LANE_SUM((axis)->weight[tap], l))

// The vector of lane l in its box of taps. A vector of a whole box is read as four values; the last is not used.
HOT float3 vector_in(const box_t *box, const offsets_t *at, const int is_whole,
                     __global const float *values, int l) {
  float4 sum = 0;
  UNROLL_ALL for (int k = 0; k < SAMPLE_TAPS; ++k)
    UNROLL_ALL for (int j = 0; j < SAMPLE_TAPS; ++j) {
      __global const float *row =
          values + (is_whole ? LANE_OFFSET(at->corner, l) + k * box->step_z + j * box->step_y
                             : LANE_OFFSET(at->z[k], l) + LANE_OFFSET(at->y[j], l));
      float4 along_x = 0;
      UNROLL_ALL for (int i = 0; i < SAMPLE_TAPS; ++i) {
        const float4 tap = is_whole ? vload4(0, row + i * box->step_x)
                                    : (float4)(vload3(0, row + LANE_OFFSET(at->x[i], l)), 0);
        along_x = fma((float4)(TAP_WEIGHT(&box->x, i, l)), tap, along_x);
      }
      const float weight = TAP_WEIGHT(&box->y, j, l) * TAP_WEIGHT(&box->z, k, l);
      sum = fma((float4)(weight), along_x, sum);
    }
  return sum.xyz;
}

inline vec vectors_at(const array_t *array, __global const float *values, vec at) {
  const axes_t axes = axes_of(array, 3);
  box_t box;
  offsets_t taps;
  vec result;
  const integer is_whole = find_box(&box, &axes, at);
  // not in the last slice: nothing can be read behind the last vector of the array
  if (ALL(is_whole & (box.z.first < axes.z.stored - SAMPLE_TAPS))) {
    taps.corner = offset_of(&axes, box.x.first, box.y.first, box.z.first);
    UNROLL_ALL for (int l = 0; l < LANES; ++l)
      set_lane(&result, l, vector_in(&box, &taps, 1, values, l));
    return result;
  }
  taps = offsets_in(&box, &axes, at);
  for (int l = 0; l < LANES; ++l) set_lane(&result, l, vector_in(&box, &taps, 0, values, l));
  return vec_select((vec){0, 0, 0}, result, are_inside(&axes, at));
}
#endif
