#include "on_grid.cl"
#include "coarse_map.cl"

// A row of points from planes to x, y, z of one after the other, as 3 * COARSE_STEP vectors.
HOT void interleave(points_t *row) {
  vec d[COARSE_STEP];
  for (int n = 0; n < COARSE_STEP; ++n)
    d[n] = (vec){row->at[n], row->at[COARSE_STEP + n], row->at[2 * COARSE_STEP + n]};
  for (int n = 0; n < COARSE_STEP; ++n) set_interleaved(row->at + 3 * n, d[n]);
}

// Interleaved displacements, from local to world units.
typedef struct {
  real scale, mean[3];
} to_world_t;

inline to_world_t to_world_of(const world_t *world) {
  const float *mean = world->mean_displacement;
  to_world_t to_world = {world->scale};
  set_interleaved(to_world.mean, (vec){mean[0], mean[1], mean[2]});
  return to_world;
}

// Interpolates the n-th vector of the rows of a cell b, and stores `scale` times that plus `offset` in rows
// of `along` floats, in the first at `to`.
HOT void store_column(__global float *to, long along, const layer_t *layer, int b, int n, real scale,
                      real offset, const int is_streamed) {
  real column[COARSE_STEP];
  interpolate_column(column, layer, b, n, 0);
  UNROLL_ALL for (int j = 0; j < COARSE_STEP; ++j) {
    const real value = fma(scale, column[j], offset);
    if (is_streamed)
      STREAM(value, to + j * along);
    else
      STORE(value, to + j * along);
  }
}

// The displacements of the rows of a cell, all of them in the launch, from `to` on.
HOT void store_cell(__global float *to, long along, const layer_t *layer, int b,
                    const to_world_t *to_world, const int is_streamed) {
  for (int n = 0; n < 3 * COARSE_STEP; n += 3)
    UNROLL_ALL for (int c = 0; c < 3; ++c)
      store_column(to + (n + c) * LANES, along, layer, b, n + c, to_world->scale,
                   to_world->mean[c], is_streamed);
}

// Whether all points of the rows from r to r + COARSE_STEP, the first of them `row`, are in the launch and on
// its side of all planes.
inline int is_whole(const map_t *map, const grid_t *grid, const band_t *band, const row_t *row, int r,
                    int k) {
  const row_t last = row_in_launch(grid, band, r + COARSE_STEP - 1, k);
  if (row->low > 0 || last.high < COARSE_STEP * LANES) return 0;
  for (int j = 0; CUTS && j < COARSE_STEP; ++j) {
    const row_t other = row_in_launch(grid, band, r + j, k);
    for (int n = 0; n < COARSE_STEP; ++n)
      if (!ALL(launch_mask(map, &other, n))) return 0;
  }
  return 1;
}

// Stores the displacements of those points of a row j / COARSE_STEP after the nodes b that the launch has.
inline void store_displacements_in_row(__global float *displacement, const layer_t *layer, int b, int j,
                                       const to_world_t *to_world, const map_t *map,
                                       const grid_t *grid, const row_t *row) {
  points_t points;
  for (int n = 0; n < 3 * COARSE_STEP; ++n)
    points.at[n] = interpolate_points(layer, b, n, j, 0);
  for (int n = 0; LIMITS && n < COARSE_STEP; ++n) {
    real *x = points.at + n, *y = x + COARSE_STEP, *z = y + COARSE_STEP;
    const vec d = limited_on_grid(map, grid, indices_in(row, n), (vec){*x, *y, *z});
    *x = d.x;
    *y = d.y;
    *z = d.z;
  }
  if (LIMITS) interleave(&points);
  for (int n = 0; n < COARSE_STEP; ++n) {
    const integer mask = launch_mask(map, row, n);
    real d[3];
    for (int c = 0; c < 3; ++c) d[c] = fma(to_world->scale, points.at[3 * n + c], to_world->mean[c]);
    __global float *to = displacement + 3 * (row->position + n * LANES);
    if (ALL(mask)) {
      for (int c = 0; c < 3; ++c) STORE(d[c], to + c * LANES);
      continue;
    }
    for (int l = 0; l < LANES; ++l)
      if (LANE_INT(mask, l))
        for (int c = 0; c < 3; ++c) to[3 * l + c] = ((float *)d)[3 * l + c];
  }
}

// As grid_displacement, interpolated between the nodes of `node_planes`.
__kernel EXPLICIT_VECTORS void coarse_displacement(
    MAP_ARGUMENTS, COARSE_ARGUMENTS, const world_t world, __global float *restrict displacement,
    __global float *restrict void_distance, const float scale) {
  const map_t map = THE_MAP;
  const to_world_t to_world = to_world_of(&world);
  band_t band;
  if (!find_band(&coarse, &band)) return;
  if (!has_region(&map.cuts, &band)) return;
  for (int k = 0; k < COARSE_STEP; ++k) {
    const rows_t rows = rows_in_launch(&grid, &band, k);
    if (rows.first >= rows.stop) continue;
    layer_t layer;
    interpolate_layer(&layer, &coarse, node_planes, &band, k, NO_SLOPE);
    for (int a = 0; !LIMITS && a < band.count + TAPS - 1; ++a) interleave(layer.rows + a);
    for (int r = rows.first; r < rows.stop; ++r) {
      const row_t row = row_in_launch(&grid, &band, r, k);
      const int b = r / COARSE_STEP, j = r % COARSE_STEP;
      if (!LIMITS && j == 0 && r + COARSE_STEP <= rows.stop && is_whole(&map, &grid, &band, &row, r, k)) {
        __global float *to = displacement + 3 * row.position;
        const long along = 3 * (long)grid.nx;
        if (IS_ALIGNED(to) && along % LANES == 0)
          store_cell(to, along, &layer, b, &to_world, 1);
        else
          store_cell(to, along, &layer, b, &to_world, 0);
        for (int n = 0; CUTS && n < COARSE_STEP; ++n)
          store_column(void_distance + row.position + n * LANES, grid.nx, &layer, b,
                       (PLANES - 1) * COARSE_STEP + n, scale, 0, 0);
        r += COARSE_STEP - 1;
        continue;
      }
      for (int n = 0; CUTS && n < COARSE_STEP; ++n)
        store_in_row(void_distance,
                     scale * interpolate_points(&layer, b, (PLANES - 1) * COARSE_STEP + n, j, 0), &row,
                     n, launch_mask(&map, &row, n));
      store_displacements_in_row(displacement, &layer, b, j, &to_world, &map, &grid, &row);
    }
  }
}
