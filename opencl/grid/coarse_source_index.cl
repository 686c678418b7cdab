#include "coarse_source.cl"

// As grid_source_index, interpolated between the nodes of `node_planes`.
__kernel EXPLICIT_VECTORS void coarse_source_index(
    MAP_ARGUMENTS, COARSE_ARGUMENTS, const source_t source, __global float *restrict index,
    __global float *restrict void_distance, const float scale) {
  const map_t map = THE_MAP;
  band_t band;
  if (!find_band(&coarse, &band)) return;
  if (!has_region(&map.cuts, &band)) return;
  const source_planes_t to = {&source, index, void_distance, scale};
  for (int k = 0; k < COARSE_STEP; ++k) {
    const rows_t rows = rows_in_launch(&grid, &band, k);
    if (rows.first >= rows.stop) continue;
    layer_t layer;
    interpolate_layer(&layer, &coarse, node_planes, &band, k, NO_SLOPE);
    for (int b = 0; b < band.count; ++b) {
      row_t row[COARSE_STEP];
      for (int j = 0; j < COARSE_STEP; ++j) row[j] = row_in_launch(&grid, &band, b * COARSE_STEP + j, k);
      const int first = max(rows.first - b * COARSE_STEP, 0);
      const int stop = min(rows.stop - b * COARSE_STEP, (int)COARSE_STEP);
      for (int n = 0; n < COARSE_STEP; ++n) {
        real values[PLANES][COARSE_STEP];
        for (int p = 0; p < PLANES; ++p)
          interpolate_column(values[p], &layer, b, p * COARSE_STEP + n, 0);
        for (int j = first; j < stop; ++j) {
          const vec d = {values[0][j], values[1][j], values[2][j]};
          store_source_in_row(&to, &map, &grid, row + j, n, d, values[PLANES - 1][j]);
        }
      }
    }
  }
}
