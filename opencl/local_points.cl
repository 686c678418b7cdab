// Points of the world in the local frame of control points. Build constants: README.md.

#ifdef USE_FP64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif

#include "types.cl"

#if !defined(COORDINATE) || !defined(REAL)
#error "COORDINATE or REAL is missing: float or double"
#endif

// `density` is 1 / scale; `center` has its digits beyond float in `center_rest`.
typedef struct {
  REAL density;
  float center[3];
  float center_rest[3];
} local_frame_t;

// (x - centre) / scale in three planes, computed in REAL whatever the coordinates come in: equal
// coordinates are equal points. The center comes in two parts with all of its digits;
// coordinates that are not finite come out as NaN.
KERNEL void local_points(const long count, __global const COORDINATE *restrict points,
                         const local_frame_t frame, __global float *restrict planes) {
  long first = (long)get_global_id(0) * LANES;
  long stop = min(first + LANES, count);
  for (long i = first; i < stop; ++i) {
    float x = (float)((((REAL)points[3 * i] - frame.center[0]) - frame.center_rest[0]) * frame.density);
    float y = (float)((((REAL)points[3 * i + 1] - frame.center[1]) - frame.center_rest[1]) * frame.density);
    float z = (float)((((REAL)points[3 * i + 2] - frame.center[2]) - frame.center_rest[2]) * frame.density);
    float finite = 0 * x + 0 * y + 0 * z;
    planes[i] = x + finite;
    planes[count + i] = y + finite;
    planes[2 * count + i] = z + finite;
  }
}
