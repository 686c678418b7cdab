#include "inverse.cl"

// For places x less drift v - x, world units, interleaved, from a lattice of first guesses; and what
// is left of the way next to the size of x.
KERNEL void point_forward(MAP_PARAMETERS, const long points_count,
                          __global const float *restrict points, GUESS_PARAMETERS,
                          const float scale, const float4 drift,
                          __global float *restrict displacement, __global float *restrict left) {
  const map_t map = MAP;
  const guess_t guess = GUESS;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first), way;
  mat response;
  guess_at(&guess, x, &way, &response);
  real rest = broyden(&map, x, &way, &response);
  rest = select(rest, (real)(FLT_MAX), is_cut_off(&map, x, way));
  way = vec_madd((real)(0), x, way);  // NaN stays NaN
  int lanes = (int)min((long)LANES, points_count - first);
  for (int l = 0; l < lanes; ++l) {
    __global float *to = displacement + 3 * (first + l);
    to[0] = fma(scale, LANE(way.x, l), -drift.x);
    to[1] = fma(scale, LANE(way.y, l), -drift.y);
    to[2] = fma(scale, LANE(way.z, l), -drift.z);
  }
  store_plane(left, rest, points_count, first);
}
