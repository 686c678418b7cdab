#include "map.cl"
#include "grid.cl"

// Nodes: G(v) - v less its mean, before limits, local units, in three planes of `count` points; with cuts
// the void distance in a fourth.
__kernel EXPLICIT_VECTORS void node_displacement(
    MAP_ARGUMENTS, const grid_t grid, const long count, __global float *restrict nodes) {
  const map_t map = THE_MAP;
  const long first = grid.first + (long)get_global_id(0) * LANES;
  if (first >= grid.stop) return;
  const fit_t fit = fit_at(&map, transformed(grid.frame, grid_index(&grid, first)));
  // of several steps nothing is interpolated if there are limits
  const vec d = STEPS ? map_displacement(&map, &fit) : unlimited_displacement(&map, &fit);
  store_points(nodes, d, count, first);
  if (CUTS)
    store_plane(nodes + 3 * count, void_distance_at(&map, &fit, map_displacement(&map, &fit)), count,
                first);
}
