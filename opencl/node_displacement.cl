#include "map.cl"
#include "grid.cl"

// G(v) - v less its mean, local units, for the points `first` to `stop` of a grid of `count`: three
// planes. With cuts the void distance in a fourth.
KERNEL void node_displacement(MAP_PARAMETERS, const grid_t grid, const long count,
                              __global float *restrict nodes) {
  const map_t map = MAP;
  const long first = grid.first + (long)get_global_id(0) * LANES;
  if (first >= grid.stop) return;
  const fit_t fit = fit_at(&map, transformed(grid.frame, grid_index(&grid, first)));
  vec d = moved(&map, &fit);
  store_points(nodes, d, count, first);
#if CUTS
  store_plane(nodes + 3 * count, void_distance_at(&map, &fit, d), count, first);
#endif
}
