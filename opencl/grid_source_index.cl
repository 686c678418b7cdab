#include "source_index.cl"

KERNEL void grid_source_index(MAP_PARAMETERS, const grid_t grid NODE_PARAMETERS ITEM_PARAMETERS,
                              const source_t source,
                              __global float *restrict index RIVAL_PARAMETERS) {
  const map_t map = MAP;
  item_t item = ITEM_OF_LAUNCH(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item NODES_OF_LAUNCH);
  STORE_RIVALS(&item, &map, &fit);
  store_origin_of_fit(&map, &fit, &item, &source, index);
}
