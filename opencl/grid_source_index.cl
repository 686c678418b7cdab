#include "source_index.cl"

// With cuts also the void distance, if it is wanted or tells which of rivals has a point.
KERNEL void grid_source_index(MAP_PARAMETERS, const grid_t grid NODE_PARAMETERS ITEM_PARAMETERS,
                              const source_t source,
                              __global float *restrict index
#if CUTS
                              VOID_PARAMETERS
#endif
) {
  map_t map = MAP;
  item_t item = ITEM_OF_LAUNCH(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item NODES_OF_LAUNCH);
#if CUTS
  if (void_distance) store_void_distance(&item, &map, &fit, VOID_OF_LAUNCH);
#endif
  store_origin_of_fit(&map, &fit, &item, &source, index);
}
