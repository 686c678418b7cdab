#include "on_grid.cl"

// (dG/dv)^T, row by row, for the points `first` to `stop` of a grid.
KERNEL void grid_jacobian(MAP_PARAMETERS, const grid_t grid NODE_PARAMETERS,
                          __global float *restrict jacobian RIVAL_PARAMETERS) {
  const map_t map = MAP;
  item_t item = ITEM_OF_LAUNCH(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item NODES_OF_LAUNCH);
  STORE_RIVALS(&item, &map, &fit);
  mat j = moved_jacobian(&map, &fit);
  for (int l = 0; l < item.lanes; ++l)
    if (is_kept(&item, l))
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
          jacobian[9 * (item.at + l) + 3 * row + column] =
              LANE(j.a[3 * column + row], l) + (row == column);
}
