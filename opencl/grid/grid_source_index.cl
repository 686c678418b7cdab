#include "source_index.cl"

// Three planes of source indices, and void distances unless null. Where regions compete, the void
// distances decide between them.
__kernel EXPLICIT_VECTORS void grid_source_index(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const grid_t grid, const nodes_t nodes, __global const node_t *restrict node_table,
    const coarse_t coarse, __global const int *restrict cells, __global const long *restrict listed,
    const source_t source, __global float *restrict index, __global float *restrict void_distance,
    const float scale) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  item_t item = item_of(&map, &grid, &coarse, cells, listed, void_distance);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item, &nodes, node_table);
  if (void_distance) store_void_distance(&item, &map, &fit, void_distance, scale);
  store_masked_planes(index, source_index_of_fit(&map, &fit, &item, &source), &item);
}
