#include "on_grid.cl"

// G(v) - v, world units, interleaved, for the points of a launch, unless only the void distance is
// wanted, which there is with cuts.
KERNEL void grid_displacement(MAP_PARAMETERS, const grid_t grid NODE_PARAMETERS ITEM_PARAMETERS,
                              const world_t world,
                              __global float *restrict displacement
#if CUTS
                              VOID_PARAMETERS
#endif
) {
  map_t map = MAP;
  item_t item = ITEM_OF_LAUNCH(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item NODES_OF_LAUNCH);
#if CUTS
  store_void_distance(&item, &map, &fit, VOID_OF_LAUNCH);
#endif
  if (!displacement) return;
  const vec mean = {world.mean_displacement[0], world.mean_displacement[1],
                    world.mean_displacement[2]};
  store_kept_points(displacement, vec_madd(world.scale, moved(&map, &fit), mean), &item);
}
