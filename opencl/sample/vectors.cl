// Vectors at continuous indices of an array of three floats per point, interpolated as in resample.cl;
// 0 outside.

#ifndef SUM  // a fit may have included it
#include "sums.cl"
#endif
#include "taps.cl"

inline void set_lane(vec *vectors, float4 vector, int l) {
  LANE(vectors->x, l) = vector.x, LANE(vectors->y, l) = vector.y, LANE(vectors->z, l) = vector.z;
}

#if SAMPLE_TAPS == 1
inline vec vectors_at(const array_t *array, __global const float *values, vec at) {
  const axes_t axes = axes_of(array, 3);
  const offset_t nearest = nearest_offset(&axes, at);
  vec result;
  for (int l = 0; l < LANES; ++l)
    set_lane(&result, (float4)(vload3(0, values + LANE_OFFSET(nearest, l)), 0), l);
  return vec_select((vec){0, 0, 0}, result, are_inside(&axes, at));
}
#else
#define TAP_WEIGHT(axis, tap, l) ((float)LANE_SUM((axis)->weight[tap], l))

// The vector of lane l in a box that is whole. Each tap is a vector of four; the last is not used.
HOT float4 whole_vector(const box_t *box, __global const float *corner, int l) {
  float4 sum = 0;
  UNROLL_ALL for (int k = 0; k < SAMPLE_TAPS; ++k)
    UNROLL_ALL for (int j = 0; j < SAMPLE_TAPS; ++j) {
      __global const float *row = corner + k * box->step_z + j * box->step_y;
      float4 along_x = TAP_WEIGHT(&box->x, 0, l) * vload4(0, row);
      UNROLL_ALL for (int i = 1; i < SAMPLE_TAPS; ++i)
        along_x = fma((float4)(TAP_WEIGHT(&box->x, i, l)), vload4(0, row + 3 * i), along_x);
      const float weight = TAP_WEIGHT(&box->y, j, l) * TAP_WEIGHT(&box->z, k, l);
      sum = fma((float4)(weight), along_x, sum);
    }
  return sum;
}

// The offset of a tap of lane l along an axis.
inline OFFSET tap_offset(const axis_t *axis, const taps_t *taps, int tap, int l) {
  return clamp(LANE_INT(taps->first, l) + tap, 0, axis->stored - 1) * axis->step;
}

// The same at a border and on grid points: taps without weight are not read.
inline float4 border_vector(const axes_t *axes, const box_t *box, __global const float *values,
                            int l) {
  float4 sum = 0;
  for (int k = 0; k < SAMPLE_TAPS; ++k)
    for (int j = 0; j < SAMPLE_TAPS; ++j) {
      const float weight = TAP_WEIGHT(&box->y, j, l) * TAP_WEIGHT(&box->z, k, l);
      if (weight == 0) continue;
      __global const float *row =
          values + tap_offset(&axes->z, &box->z, k, l) + tap_offset(&axes->y, &box->y, j, l);
      float4 along_x = 0;
      for (int i = 0; i < SAMPLE_TAPS; ++i) {
        const float share = TAP_WEIGHT(&box->x, i, l);
        if (share == 0) continue;
        const float3 tap = vload3(0, row + tap_offset(&axes->x, &box->x, i, l));
        along_x = fma((float4)(share), (float4)(tap, 0), along_x);
      }
      sum = fma((float4)(weight), along_x, sum);
    }
  return sum;
}

inline vec vectors_at(const array_t *array, __global const float *values, vec at) {
  const axes_t axes = axes_of(array, 3);
  box_t box;
  const integer is_whole = find_box(&box, &axes, at);
  vec result;
  // not in the last slice: nothing can be read behind the last vector of the array
  if (ALL(is_whole & (box.z.first < axes.z.stored - SAMPLE_TAPS))) {
    const offset_t corner = offset_of(&axes, box.x.first, box.y.first, box.z.first);
    UNROLL_ALL for (int l = 0; l < LANES; ++l)
      set_lane(&result, whole_vector(&box, values + LANE_OFFSET(corner, l), l), l);
    return result;
  }
  for (int l = 0; l < LANES; ++l) set_lane(&result, border_vector(&axes, &box, values, l), l);
  return vec_select((vec){0, 0, 0}, result, are_inside(&axes, at));
}
#endif
