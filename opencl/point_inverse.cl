#include "inverse.cl"

// For places x less drift the way to v with G(v) = x, from first guesses in `ways`, three planes;
// and what is left of it next to the size of x.
KERNEL void point_inverse(MAP_PARAMETERS, const long points_count,
                          __global const float *restrict points, __global float *restrict ways,
                          __global float *restrict left) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first), way = load_points(ways, points_count, first);
#if CUTS
  way = vec_select(way, drift_of(&map.cuts), is_blocked(&map, x, way));  // to x itself
#endif
  real rest = newton(&map, x, &way);
  rest = select(rest, (real)(FLT_MAX), is_cut_off(&map, x, way));
  store_points(ways, way, points_count, first);
  store_plane(left, rest, points_count, first);
}
