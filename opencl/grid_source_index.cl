#include "source_index.cl"

KERNEL void grid_source_index(MAP_PARAMETERS, const grid_t grid, const source_t source,
                              __global float *restrict index) {
  const map_t map = MAP;
  const item_t item = item_of(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_at(&map, transformed(grid.frame, item.index));
  store_source_index(&map, &fit, &item, &source, index);
}
