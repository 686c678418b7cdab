#include "map.cl"
#if AT_REST
#include "searches.cl"
#endif

// G(v) - v - mean displacement in three planes, local frame; the void distance in a fourth if cuts
// belong to the material.
__kernel EXPLICIT_VECTORS void point_displacement(
    MAP_ARGUMENTS, POINT_ARGUMENTS, __global float *restrict displacement) {
  const map_t map = THE_MAP;
#if AT_REST
  search_points(&map, points_count, points, 0, displacement);
#else
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  fit_t fit = fit_at(&map, load_points(points, points_count, first));
  vec d = map_displacement(&map, &fit);
  store_points(displacement, d, points_count, first);
  if (CUTS && (STEPS || regions_compete(&map.cuts)))
    store_plane(displacement + 3 * points_count, void_distance_at(&map, &fit, d), points_count,
                first);
#endif
}
