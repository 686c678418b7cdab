#include "on_grid.cl"

// (dG/dv)^T, row by row, for the points `first` to `stop` of a grid.
KERNEL void grid_jacobian(MAP_PARAMETERS, GRID_PARAMETERS, __global float *restrict jacobian) {
  FIT_ON_GRID
  mat j = moved_jacobian(&map, &fit);
  for (int l = 0; l < lanes; ++l)
    if (KEPT(l))
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
          jacobian[9 * (at + l) + 3 * row + column] =
              LANE(j.a[3 * column + row], l) + (row == column);
}
