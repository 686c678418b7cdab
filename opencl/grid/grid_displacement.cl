#include "on_grid.cl"

// G(v) - v, world units, interleaved, and void distances; outputs that are null are left out.
__kernel EXPLICIT_VECTORS void grid_displacement(
    MAP_ARGUMENTS, GRID_ARGUMENTS, const world_t world, __global float *restrict displacement,
    __global float *restrict void_distance, const float scale) {
  const map_t map = THE_MAP;
  item_t item = item_of(&map, &grid, &coarse, cells, listed, void_distance);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item, &nodes, node_table);
  if (void_distance) store_void_distance(&item, &map, &fit, void_distance, scale);
  if (!displacement) return;
  const vec mean = {world.mean_displacement[0], world.mean_displacement[1],
                    world.mean_displacement[2]};
  const vec d = vec_madd(world.scale, map_displacement(&map, &fit), mean);
  store_masked_points(displacement, d, &item);
}
