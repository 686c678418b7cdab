#include "source_index.cl"
#include "coarse_map.cl"

// As grid_source_index, or `with_jacobian` as grid_source_frame, interpolated between the nodes of
// `node_planes`.
__kernel EXPLICIT_VECTORS void coarse_source_index(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const grid_t grid, const coarse_t coarse, __global const float *restrict node_planes,
    const source_t source, __global float *restrict index, __global float *restrict void_distance,
    const float scale, const int with_jacobian) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  strip_t strip;
  if (!find_strip(&coarse, &strip)) return;
#if CUTS
  if (!ANY(may_be_in_region(&map.cuts, first_corners(&strip)))) return;
#endif
  const long count = grid.stop - grid.first;
  for (int k = 0; k < COARSE_STEP; ++k) {
    layer_t layer, along_x, along_z;
    int has_layer = 0;
    for (int j = 0; j < COARSE_STEP; ++j) {
      row_t row;
      if (!find_row(&row, &grid, &strip, j, k)) continue;
      if (!has_layer) {
        interpolate_layer(&layer, &coarse, node_planes, &strip, k, NO_SLOPE);
        if (with_jacobian) {
          interpolate_layer(&along_x, &coarse, node_planes, &strip, k, 0);
          interpolate_layer(&along_z, &coarse, node_planes, &strip, k, 2);
        }
      }
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
      if (!with_jacobian) continue;
      for (int p = 0; p < 3; ++p) {
        real slope[3][COARSE_STEP];
        interpolate_row(slope[0], &along_x, p, j, 0);
        interpolate_row(slope[1], &layer, p, j, 1);
        interpolate_row(slope[2], &along_z, p, j, 0);
        for (int n = 0; n < COARSE_STEP; ++n) {
          vec by_v =
              transformed(coarse.to_slopes, (vec){slope[0][n], slope[1][n], slope[2][n]});
          by_v.x += p == 0;
          by_v.y += p == 1;
          by_v.z += p == 2;
          store_vec_in_row(index + (3 + 3 * p) * count, count, by_v, &row, n,
                           launch_mask(&map, &row, n));
        }
      }
    }
  }
}
