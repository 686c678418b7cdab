#include "on_grid.cl"

// G(v) - v, world units, interleaved, for the points `first` to `stop` of a grid; with cuts also the
// void distance.
KERNEL void grid_displacement(MAP_PARAMETERS, const grid_t grid NODE_PARAMETERS ITEM_PARAMETERS,
                              const world_t world,
                              __global float *restrict displacement
#if CUTS
                              VOID_PARAMETERS
#endif
) {
  map_t map = MAP;
  TAKE_LIST(&map);
  item_t item = ITEM_OF_LAUNCH(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item NODES_OF_LAUNCH);
  vec d = moved(&map, &fit);
#if CUTS
  store_void_distance(&item, &map, &fit, VOID_OF_LAUNCH);
#endif
  for (int l = 0; l < item.lanes; ++l)
    if (is_kept(&item, l)) {
      __global float *to = displacement + 3 * position_of(&item, l);
      to[0] = fma(world.scale, LANE(d.x, l), world.mean_displacement[0]);
      to[1] = fma(world.scale, LANE(d.y, l), world.mean_displacement[1]);
      to[2] = fma(world.scale, LANE(d.z, l), world.mean_displacement[2]);
    }
}
