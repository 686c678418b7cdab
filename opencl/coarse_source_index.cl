#include "source_index.cl"

// What grid_source_index writes, interpolated between nodes; with FRAMES what grid_source_frame does.
KERNEL void coarse_source_index(MAP_PARAMETERS, const grid_t grid, const coarse_t coarse,
                                __global const float *restrict nodes, const source_t source,
                                __global float *restrict index
#if CUTS
                                VOID_PARAMETERS
#endif
) {
#if CUTS
  const map_t map = MAP;
#endif
  strip_t strip;
  if (!strip_of(&coarse, &strip)) return;
#if CUTS
  if (!ANY(in_reach(&map.cuts, corners_of(&strip)))) return;
#endif
  const long count = grid.stop - grid.first;
  for (int k = 0; k < COARSE_STEP; ++k) {
    layer_t layer;
#if FRAMES
    layer_t along_x, along_z;
#endif
    int is_there = 0;
    for (int j = 0; j < COARSE_STEP; ++j) {
      row_t row;
      if (!row_of_strip(&row, &grid, &strip, j, k)) continue;
      if (!is_there) {
        layer_between(&layer, &coarse, nodes, &strip, k, NO_SLOPE);
#if FRAMES
        layer_between(&along_x, &coarse, nodes, &strip, k, 0);
        layer_between(&along_z, &coarse, nodes, &strip, k, 2);
#endif
      }
      is_there = 1;
      real found[PLANES][COARSE_STEP];
      for (int p = 0; p < PLANES; ++p) row_between(found[p], &layer, p, j, 0);
#if FRAMES
      real slope[3][3][COARSE_STEP];
      for (int p = 0; p < 3; ++p) {
        row_between(slope[p][0], &along_x, p, j, 0);
        row_between(slope[p][1], &layer, p, j, 1);
        row_between(slope[p][2], &along_z, p, j, 0);
      }
#endif
      for (int n = 0; n < COARSE_STEP; ++n) {
        const vec at = indices_in(&row, n), d = {found[0][n], found[1][n], found[2][n]};
        vec from = source_index_of(&source, at, d);
        integer kept = are_in_launch(&row, n);
#if CUTS
        const real distance = found[3][n];
        if (!source.continued) from = outside_if(from, distance < 0);
        kept &= in_region(&map.cuts, at);
        if (void_distance) store_in_row(void_distance, scale * distance, &row, n, kept);
#endif
        store_in_row(index, from.x, &row, n, kept);
        store_in_row(index + count, from.y, &row, n, kept);
        store_in_row(index + 2 * count, from.z, &row, n, kept);
#if FRAMES
        for (int p = 0; p < 3; ++p) {
          const vec by_index = {slope[p][0][n], slope[p][1][n], slope[p][2][n]};
          vec by_v = transformed(coarse.to_slopes, by_index);
          by_v.x += p == 0;
          by_v.y += p == 1;
          by_v.z += p == 2;
          __global float *plane = index + (3 + 3 * p) * count;
          store_in_row(plane, by_v.x, &row, n, kept);
          store_in_row(plane + count, by_v.y, &row, n, kept);
          store_in_row(plane + 2 * count, by_v.z, &row, n, kept);
        }
#endif
      }
    }
  }
}
