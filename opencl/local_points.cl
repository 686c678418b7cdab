// Points of the world in the local frame of control points. Build constants: README.md.

#ifdef USE_FP64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif

#include "types.cl"

#ifndef COORDINATE
#error "COORDINATE is missing: float or double"
#endif

// (x - centre) / scale in three planes. The centre comes in two parts, so that its digits are all
// there; coordinates that are not finite come out as NaN.
KERNEL void local_points(const long count, __global const COORDINATE *restrict points,
                     const float4 centre, const float4 centre_rest, const COORDINATE density,
                     __global float *restrict planes) {
  long first = (long)get_global_id(0) * LANES;
  long stop = min(first + LANES, count);
  for (long i = first; i < stop; ++i) {
    float x = (float)(((points[3 * i] - centre.x) - centre_rest.x) * density);
    float y = (float)(((points[3 * i + 1] - centre.y) - centre_rest.y) * density);
    float z = (float)(((points[3 * i + 2] - centre.z) - centre_rest.z) * density);
    float finite = 0 * x + 0 * y + 0 * z;
    planes[i] = x + finite;
    planes[count + i] = y + finite;
    planes[2 * count + i] = z + finite;
  }
}
