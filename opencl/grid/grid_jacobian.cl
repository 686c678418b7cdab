#include "on_grid.cl"

// (dG/dv)^T, row by row. Where regions compete, `void_distance` decides between them.
__kernel EXPLICIT_VECTORS void grid_jacobian(
    MAP_ARGUMENTS, GRID_ARGUMENTS, __global float *restrict jacobian,
    __global float *restrict void_distance, const float scale) {
  const map_t map = THE_MAP;
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
