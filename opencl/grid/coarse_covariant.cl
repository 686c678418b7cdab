#include "coarse_source.cl"
#include "vectors.cl"

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

// As grid_covariant, interpolated between the nodes of `node_planes`.
__kernel EXPLICIT_VECTORS void coarse_covariant(
    MAP_ARGUMENTS, COARSE_ARGUMENTS, const source_t source, __global float *restrict index,
    __global float *restrict void_distance, const float scale, const array_t array,
    const int normalize, __global const float *restrict vectors, __global float *restrict result) {
  const map_t map = THE_MAP;
  band_t band;
  if (!find_band(&coarse, &band)) return;
  if (!has_region(&map.cuts, &band)) return;
  const source_planes_t to = {&source, index, void_distance, scale};
  for (int k = 0; k < COARSE_STEP; ++k) {
    const rows_t rows = rows_in_launch(&grid, &band, k);
    if (rows.first >= rows.stop) continue;
    layer_t layer, along_x, along_z;
    interpolate_layer(&layer, &coarse, node_planes, &band, k, NO_SLOPE);
    interpolate_layer(&along_x, &coarse, node_planes, &band, k, 0);
    interpolate_layer(&along_z, &coarse, node_planes, &band, k, 2);
    for (int b = 0; b < band.count; ++b) {
      row_t row[COARSE_STEP];
      for (int j = 0; j < COARSE_STEP; ++j) row[j] = row_in_launch(&grid, &band, b * COARSE_STEP + j, k);
      const int first = max(rows.first - b * COARSE_STEP, 0);
      const int stop = min(rows.stop - b * COARSE_STEP, (int)COARSE_STEP);
      for (int n = 0; n < COARSE_STEP; ++n) {
        real values[PLANES][COARSE_STEP];
        for (int p = 0; p < PLANES; ++p)
          interpolate_column(values[p], &layer, b, p * COARSE_STEP + n, 0);
        slopes_t slopes;
        for (int p = 0; p < 3; ++p) {
          interpolate_column(slopes.along[0][p], &along_x, b, p * COARSE_STEP + n, 0);
          interpolate_column(slopes.along[1][p], &layer, b, p * COARSE_STEP + n, 1);
          interpolate_column(slopes.along[2][p], &along_z, b, p * COARSE_STEP + n, 0);
        }
        for (int j = first; j < stop; ++j) {
          const vec d = {values[0][j], values[1][j], values[2][j]};
          const vec from = store_source_in_row(&to, &map, &grid, row + j, n, d, values[PLANES - 1][j]);
          const vec vector =
              covariant_in_row(&coarse, &slopes, j, vectors_at(&array, vectors, from));
          store_points_in_row(result, normalize ? unit3(vector) : vector, row + j, n,
                              launch_mask(&map, row + j, n));
        }
      }
    }
  }
}
