#include "map.cl"
#include "grid.cl"
#include "coarse_map.cl"

// Nodes: G(v) - v less its mean, before limits, local units, in three planes of `count` points; with cuts
// the void distance in a fourth. Those of a launch, or with the indices `listed`, if that is not null.
__kernel EXPLICIT_VECTORS void node_displacement(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const grid_t grid, const long count, __global const long *restrict listed,
    __global float *restrict nodes) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  const long first = grid.first + (long)get_global_id(0) * LANES;
  if (first >= grid.stop) return;
  const vec index =
      listed ? listed_index(&grid, listed, grid.stop, first) : grid_index(&grid, first);
  const fit_t fit = fit_at(&map, transformed(grid.frame, index));
  real values[PLANES];
  set_node(values, &map, &fit);
  for (int p = 0; p < PLANES; ++p) {
    __global float *plane = nodes + p * count;
    if (!listed) {
      store_plane(plane, values[p], count, first);
      continue;
    }
    for (int l = 0; l < LANES && first + l < grid.stop; ++l)
      plane[listed[first + l]] = LANE(values[p], l);
  }
}
