#include "on_grid.cl"

// (dG/dv)^T, row by row. Where regions compete, `void_distance` decides between them.
__kernel EXPLICIT_VECTORS void grid_jacobian(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const grid_t grid, const nodes_t nodes, __global const node_t *restrict node_table,
    const coarse_t coarse, __global const int *restrict cells, __global const long *restrict listed,
    __global float *restrict jacobian, __global float *restrict void_distance, const float scale) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  item_t item = item_of(&map, &grid, &coarse, cells, listed, void_distance);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item, &nodes, node_table);
  if (void_distance) store_void_distance(&item, &map, &fit, void_distance, scale);
  mat j = map_jacobian(&map, &fit);
  for (int l = 0; l < item.lanes; ++l)
    if (LANE_INT(item.mask, l))
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
          jacobian[9 * position_of(&item, l) + 3 * row + column] =
              LANE(j.a[3 * column + row], l) + (row == column);
}
