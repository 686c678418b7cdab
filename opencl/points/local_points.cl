// Points of the world in the local frame of control points.

#include "types.cl"
#include "sums.cl"

#ifndef VALUE
#error "VALUE is missing: type of the coordinates"
#endif

inline float local_coordinate(SUM x, float center, float center_rest, SUM density) {
  return (float)(((x - center) - center_rest) * density);
}

// (x - center) * density in three planes, computed in SUM, for density = 1 / scale: equal coordinates
// give equal points. Coordinates that are not finite become NaN.
__kernel EXPLICIT_VECTORS void local_points(
    const long count, __global const VALUE *restrict points, const local_frame_t frame,
    const SUM density, __global float *restrict planes) {
  long first = (long)get_global_id(0) * LANES;
  long stop = min(first + LANES, count);
  for (long i = first; i < stop; ++i) {
    float x = local_coordinate(points[3 * i], frame.center[0], frame.center_rest[0], density);
    float y = local_coordinate(points[3 * i + 1], frame.center[1], frame.center_rest[1], density);
    float z = local_coordinate(points[3 * i + 2], frame.center[2], frame.center_rest[2], density);
    float finite = 0 * x + 0 * y + 0 * z;
    planes[i] = x + finite;
    planes[count + i] = y + finite;
    planes[2 * count + i] = z + finite;
  }
}
