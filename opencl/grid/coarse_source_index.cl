#include "source_index.cl"
#include "coarse_map.cl"

// Derivatives along the axes of the grid in a column of rows, from point to point.
typedef struct { real along[3][3][COARSE_STEP]; } slopes_t;

// J^T n in row j of the column.
inline vec covariant_in_row(const coarse_t *coarse, const slopes_t *slopes, int j, vec vector) {
  vec sum = {0, 0, 0};
  const real components[3] = {vector.x, vector.y, vector.z};
  for (int p = 0; p < 3; ++p)
    sum = vec_madd(components[p],
                   (vec){slopes->along[0][p][j], slopes->along[1][p][j], slopes->along[2][p][j]}, sum);
  return vec_add(vector, transformed(coarse->to_slopes, sum));
}

// As grid_source_index, interpolated between the nodes of `node_planes`.
__kernel EXPLICIT_VECTORS void coarse_source_index(MAP_ARGUMENTS, COARSE_ARGUMENTS,
                                                   SOURCE_ARGUMENTS) {
  const map_t map = THE_MAP;
  const long count = grid.stop - grid.first;
  band_t band;
  if (!find_band(&coarse, &band)) return;
  if (!has_region(&map.cuts, &band)) return;
  for (int k = 0; k < COARSE_STEP; ++k) {
    const rows_t rows = rows_in_launch(&grid, &band, k);
    if (rows.first >= rows.stop) continue;
    layer_t layer, along_x, along_z;
    interpolate_layer(&layer, &coarse, node_planes, &band, k, NO_SLOPE);
    if (HAS_VECTORS) interpolate_layer(&along_x, &coarse, node_planes, &band, k, 0);
    if (HAS_VECTORS) interpolate_layer(&along_z, &coarse, node_planes, &band, k, 2);
    for (int b = 0; b < band.count; ++b) {
      row_t in_launch[COARSE_STEP];
      for (int j = 0; j < COARSE_STEP; ++j)
        in_launch[j] = row_in_launch(&grid, &band, b * COARSE_STEP + j, k);
      const int first = max(rows.first - b * COARSE_STEP, 0);
      const int stop = min(rows.stop - b * COARSE_STEP, (int)COARSE_STEP);
      for (int n = 0; n < COARSE_STEP; ++n) {
        real values[PLANES][COARSE_STEP];
        for (int p = 0; p < PLANES; ++p)
          interpolate_column(values[p], &layer, b, p * COARSE_STEP + n, 0);
        slopes_t slopes;
        for (int p = 0; HAS_VECTORS && p < 3; ++p) {
          interpolate_column(slopes.along[0][p], &along_x, b, p * COARSE_STEP + n, 0);
          interpolate_column(slopes.along[1][p], &layer, b, p * COARSE_STEP + n, 1);
          interpolate_column(slopes.along[2][p], &along_z, b, p * COARSE_STEP + n, 0);
        }
        for (int j = first; j < stop; ++j) {
          const row_t *row = in_launch + j;
          const vec at = indices_in(row, n), unlimited = {values[0][j], values[1][j], values[2][j]};
          const real distance = values[PLANES - 1][j];
          const integer is_void = CUTS && !source.continued ? distance < 0 : (integer)(0);
          const vec d = limited_on_grid(&map, &grid, at, unlimited);
          const vec from = source_index_of(&source, at, d, is_void);
          const integer mask = launch_mask(&map, row, n);
          if (CUTS && void_distance) store_in_row(void_distance, scale * distance, row, n, mask);
          store_in_row(index, from.x, row, n, mask);
          store_in_row(index + count, from.y, row, n, mask);
          store_in_row(index + 2 * count, from.z, row, n, mask);
          if (!HAS_VECTORS) continue;
          const vec vector = covariant_in_row(&coarse, &slopes, j, vectors_at(&array, vectors, from));
          store_points_in_row(covariant, normalize ? unit3(vector) : vector, row, n, mask);
        }
      }
    }
  }
}
