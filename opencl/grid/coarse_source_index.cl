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
  band_t band;
  if (!find_band(&coarse, &band)) return;
#if CUTS
  if (!has_region(&map.cuts, &band)) return;
#endif
  const long count = grid.stop - grid.first;
  for (int k = 0; k < COARSE_STEP; ++k) {
    const rows_t rows = rows_in_launch(&grid, &band, k);
    if (rows.first >= rows.stop) continue;
    layer_t layer, along_x, along_z;
    interpolate_layer(&layer, &coarse, node_planes, &band, k, NO_SLOPE);
    if (with_jacobian) {
      interpolate_layer(&along_x, &coarse, node_planes, &band, k, 0);
      interpolate_layer(&along_z, &coarse, node_planes, &band, k, 2);
    }
    for (int r = rows.first; r < rows.stop; ++r) {
      const row_t row = row_in_launch(&grid, &band, r, k);
      const int b = r / COARSE_STEP, j = r % COARSE_STEP;
      for (int n = 0; n < COARSE_STEP; ++n) {
        const vec at = indices_in(&row, n);
        const vec d = limited_on_grid(&map, &grid, at, displacement_in(&layer, b, n, j));
        vec from = source_index_of(&source, at, d);
        const integer mask = launch_mask(&map, &row, n);
#if CUTS
        const real distance = interpolate_points(&layer, b, 3 * COARSE_STEP + n, j, 0);
        if (!source.continued) from = outside_if(from, distance < 0);
        if (void_distance) store_in_row(void_distance, scale * distance, &row, n, mask);
#endif
        store_vec_in_row(index, count, from, &row, n, mask);
        if (!with_jacobian) continue;
        for (int p = 0; p < 3; ++p) {
          const int m = p * COARSE_STEP + n;
          const vec slopes = {interpolate_points(&along_x, b, m, j, 0),
                              interpolate_points(&layer, b, m, j, 1),
                              interpolate_points(&along_z, b, m, j, 0)};
          vec by_v = transformed(coarse.to_slopes, slopes);
          by_v.x += p == 0;
          by_v.y += p == 1;
          by_v.z += p == 2;
          store_vec_in_row(index + (3 + 3 * p) * count, count, by_v, &row, n, mask);
        }
      }
    }
  }
}
