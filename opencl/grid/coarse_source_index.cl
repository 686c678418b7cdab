#include "source_index.cl"
#include "coarse_map.cl"

// As grid_source_index, interpolated between the nodes of `node_planes`.
__kernel EXPLICIT_VECTORS void coarse_source_index(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const grid_t grid, const coarse_t coarse, __global const float *restrict node_planes,
    const source_t source, __global float *restrict index, __global float *restrict void_distance,
    const float scale) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  strip_t strip;
  if (!find_strip(&coarse, &strip)) return;
#if CUTS
  if (!ANY(may_be_in_region(&map.cuts, first_corners(&strip)))) return;
#endif
  const long count = grid.stop - grid.first;
  for (int k = 0; k < COARSE_STEP; ++k) {
    layer_t layer;
    int has_layer = 0;
    for (int j = 0; j < COARSE_STEP; ++j) {
      row_t row;
      if (!find_row(&row, &grid, &strip, j, k)) continue;
      if (!has_layer) interpolate_layer(&layer, &coarse, node_planes, &strip, k, NO_SLOPE);
      has_layer = 1;
      real values[PLANES][COARSE_STEP];
      for (int p = 0; p < PLANES; ++p) interpolate_row(values[p], &layer, p, j, 0);
      for (int n = 0; n < COARSE_STEP; ++n) {
        const vec at = indices_in(&row, n), d = {values[0][n], values[1][n], values[2][n]};
        vec from = source_index_of(&source, at, limited_on_grid(&map, &grid, at, d));
        const integer mask = launch_mask(&map, &row, n);
#if CUTS
        const real distance = values[3][n];
        if (!source.continued) from = outside_if(from, distance < 0);
        if (void_distance) store_in_row(void_distance, scale * distance, &row, n, mask);
#endif
        store_vec_in_row(index, count, from, &row, n, mask);
      }
    }
  }
}
