#include "map.cl"
#include "grid.cl"
#include "coarse_map.cl"
#include "fine_map.cl"

// Compares the map in the middles of listed fine cells with its interpolation: bits of structs.h.
__kernel EXPLICIT_VECTORS void fine_check(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const grid_t grid, const coarse_t fine, __global const int *restrict cells,
    __global const float *restrict fine_planes, const check_t check,
    __global uchar *restrict flags) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  const long first = (long)get_global_id(0) * LANES;
  if (first >= fine.listed) return;
  const long along = fine.nodes[0], deep = along * fine.nodes[1];
  real interpolated[PLANES], exact[PLANES];
  integer x, y, z;  // of the middles, points of the grid
  for (int l = 0; l < LANES; ++l) {
    const int3 corner = cell_corner(&fine, listed_cell(&fine, cells, first + l));
    LANE_INT(x, l) = (corner.x + fine.first_node[0]) * FINE_STEP + FINE_STEP / 2;
    LANE_INT(y, l) = (corner.y + fine.first_node[1]) * FINE_STEP + FINE_STEP / 2;
    LANE_INT(z, l) = (corner.z + fine.first_node[2]) * FINE_STEP + FINE_STEP / 2;
    __global const float *from = fine_planes + node_at(&fine, corner) - BEFORE * (1 + along + deep);
    for (int p = 0; p < PLANES; ++p)
      LANE(interpolated[p], l) = value_in(row_of(from + p * node_count(&fine), along, deep, 1, 1), 1);
  }
  const vec index = {TO_REAL(x), TO_REAL(y), TO_REAL(z)};
  const fit_t fit = fit_at(&map, transformed(grid.frame, index));
  set_node(exact, &map, &fit);
  const integer bits = accuracy_flags(&check, interpolated, exact);
  for (int l = 0; l < LANES && first + l < fine.listed; ++l)
    flags[first + l] = (uchar)LANE_INT(bits, l);
}
