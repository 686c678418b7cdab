#include "on_grid.cl"
#include "coarse_map.cl"
#include "fine_map.cl"

// As grid_displacement, interpolated in listed fine cells.
__kernel EXPLICIT_VECTORS void fine_displacement(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const grid_t grid, const coarse_t fine, __global const int *restrict cells,
    __global const float *restrict fine_planes, const world_t world,
    __global float *restrict displacement, __global float *restrict void_distance,
    const float scale) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  item_t item = item_of(&map, &grid, &fine, cells, 0, void_distance);
  if (item.lanes == 0) return;
  real values[PLANES];
  interpolate_places(values, &fine, fine_planes, cells, item.first);
#if CUTS
  store_masked(void_distance, scale * values[3], &item);
#endif
  const vec mean = {world.mean_displacement[0], world.mean_displacement[1],
                    world.mean_displacement[2]};
  const vec d =
      limited_on_grid(&map, &grid, item.index, (vec){values[0], values[1], values[2]});
  store_masked_points(displacement, vec_madd(world.scale, d, mean), &item);
}
