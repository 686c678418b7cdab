#include "map.cl"
#if AT_REST
#include "searches.cl"
#endif

// G(v) - v - mean displacement in three planes, local frame; with cuts in the rest frame the void
// distance in a fourth.
KERNEL void point_displacement(MAP_PARAMETERS, const long points_count,
                               __global const float *restrict points,
                               __global float *restrict displacement) {
  const map_t map = MAP;
#if AT_REST
  search_points(&map, points_count, points, 0, displacement);
#else
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  fit_t fit = fit_at(&map, load_points(points, points_count, first));
  vec d = moved(&map, &fit);
  store_points(displacement, d, points_count, first);
#if RIVALS
  real nothing = void_distance_at(&map, &fit, d);
  store_plane(displacement + 3 * points_count, nothing, points_count, first);
#endif
#endif
}
