#include "source_index.cl"

// Three planes of source indices, and void distances unless null. Where regions compete, the void
// distances decide between them.
__kernel EXPLICIT_VECTORS void grid_source_index(
    MAP_ARGUMENTS, GRID_ARGUMENTS, const source_t source, __global float *restrict index,
    __global float *restrict void_distance, const float scale) {
  const map_t map = THE_MAP;
  item_t item = item_of(&map, &grid, &coarse, cells, listed, void_distance);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item, &nodes, node_table);
  if (void_distance) store_void_distance(&item, &map, &fit, void_distance, scale);
  store_masked_planes(index, source_index_of_fit(&map, &fit, &item, &source), &item);
}
