// The map of a grid between nodes, every COARSE_STEP-th point of the whole grid along each axis: in a
// cell the polynomial of degree 5 through the six surrounding nodes along each axis. The result depends
// on the index of a point only: parts are computed like the whole. The host decides which cells are
// accurate (vtk_mls/engine/map/coarse_map.py).

// Arguments of kernels that interpolate between the nodes `node_planes`.
#define COARSE_ARGUMENTS \
  const grid_t grid, const coarse_t coarse, __global const float *restrict node_planes

#define TAPS 6
#define BEFORE 2  // nodes before the first node of a cell

// Vectors that hold a row of nodes around LANES cells.
#define VECTORS_AROUND ((LANES + TAPS - 1 + LANES - 1) / LANES)

// Lagrange weights of the nodes -2 to 3 at k / COARSE_STEP, and of the derivative from point to point.
// tests/engine/test_kernel_functions.py computes them in float64.
__constant float tap_weight[COARSE_STEP][TAPS] = {
    {0.0f, 0.0f, 1.0f, 0.0f, -0.0f, 0.0f},
    {0.00939941406f, -0.0845947266f, 0.845947266f, 0.281982422f, -0.0604248047f, 0.00769042969f},
    {0.01171875f, -0.09765625f, 0.5859375f, 0.5859375f, -0.09765625f, 0.01171875f},
    {0.00769042969f, -0.0604248047f, 0.281982422f, 0.845947266f, -0.0845947266f, 0.00939941406f}};
__constant float tap_slope[COARSE_STEP][TAPS] = {
    {0.0125000002f, -0.125f, -0.0833333358f, 0.25f, -0.0625f, 0.00833333377f},
    {0.00594889326f, -0.0460205078f, -0.216552734f, 0.303792328f, -0.0535888672f, 0.00642089825f},
    {-0.00117187505f, 0.016276041f, -0.29296875f, 0.29296875f, -0.016276041f, 0.00117187505f},
    {-0.00642089825f, 0.0535888672f, -0.303792328f, 0.216552734f, 0.0460205078f, -0.00594889326f}};

// Cells of a work item: LANES along x, and so many along y. The index of the first in all cells of the
// whole grid.
#define BAND (LANES > 1 ? BAND_CELLS : 1)
typedef struct { int x, y, z, count; } band_t;

// Finds the band of a work item; false without one.
inline int find_band(const coarse_t *coarse, band_t *band) {
  const long across = (coarse->cells[0] + LANES - 1) / LANES;
  const long along = (coarse->cells[1] + BAND - 1) / BAND;
  const long item = get_global_id(0), row = item / across;
  if (row >= along * coarse->cells[2]) return 0;
  const int y = (int)(row % along) * BAND;
  band->x = coarse->first_cell[0] + (int)(item % across) * LANES;
  band->y = coarse->first_cell[1] + y;
  band->z = coarse->first_cell[2] + (int)(row / along);
  band->count = min(BAND, coarse->cells[1] - y);
  return 1;
}

// The first corners of its cells b along y, as indices of the whole grid.
inline vec first_corners(const band_t *band, int b) {
  real x = 0;
  for (int l = 0; l < LANES; ++l) LANE(x, l) = (band->x + l) * COARSE_STEP;
  return (vec){x, (real)((band->y + b) * COARSE_STEP), (real)(band->z * COARSE_STEP)};
}

// Whether one of the cells of a band may have points on this launch's side of all planes.
inline int has_region(const cuts_t *cuts, const band_t *band) {
  if (!CUTS) return 1;
  integer has = 0;
  for (int b = 0; b < band->count; ++b)
    has |= may_be_in_region(cuts, first_corners(band, b), COARSE_STEP);
  return ANY(has);
}

// Up to so many times the limit, cells beside may be accurate.
#define SPREAD_RATIO 2

// The flags INACCURATE where interpolated values of nodes are too far from `exact` ones, and SPREADS where
// this may be so beside the cell.
inline integer accuracy_flags(const check_t *check, const real interpolated[PLANES],
                              const real exact[PLANES]) {
  real error[PLANES];
  for (int p = 0; p < PLANES; ++p) error[p] = interpolated[p] - exact[p];
  const vec steps = transformed(check->to_index, (vec){error[0], error[1], error[2]});
  const real error2 = dot3(steps, steps);
  integer flags = select((integer)(INACCURATE), (integer)(0), error2 <= check->limit2);
  flags |= select((integer)(SPREADS), (integer)(0),
                  error2 <= SPREAD_RATIO * SPREAD_RATIO * check->limit2);
  if (!CUTS) return flags;
  const integer is_void_accurate = fabs(error[PLANES - 1]) <= 0.25f * fabs(exact[PLANES - 1]);
  return select((integer)(INACCURATE | SPREADS), flags, is_void_accurate);
}

inline long node_count(const coarse_t *coarse) {
  return (long)coarse->nodes[0] * coarse->nodes[1] * coarse->nodes[2];
}

// The node that begins the first of the cells b of a band, in a plane.
inline long node_of(const coarse_t *coarse, const band_t *band, int b) {
  const int *first = coarse->first_node;
  return band->x - first[0] + BEFORE +
         coarse->nodes[0] * (band->y + b - first[1] + BEFORE +
                             (long)coarse->nodes[1] * (band->z - first[2] + BEFORE));
}

// Interpolates at k / COARSE_STEP after the first node of a cell; with `is_slope` the derivative from
// point to point.
HOT real interpolate(const real tap[TAPS], int k, const int is_slope) {
  if (k == 0 && !is_slope) return tap[BEFORE];
  __constant const float *weight = is_slope ? tap_slope[k] : tap_weight[k];
  real sum = weight[0] * tap[0];
  UNROLL_ALL for (int c = 1; c < TAPS; ++c) sum = fma((real)(weight[c]), tap[c], sum);
  return sum;
}

#define NO_SLOPE (-1)

#if LANES > 1
#define FROM(n) (n)
#define TAP(c)                                                                          \
  tap[c] = __builtin_shufflevector(row[(c) / LANES], row[(c) / LANES + 1],              \
                                   EACH_LANE(FROM, (c) % LANES));
#else
#define TAP(c) tap[c] = row[c];
#endif
// Taps along x of LANES cells, interpolated k / COARSE_STEP after a row of nodes; with `is_slope` the
// derivative along z. By shuffles: unaligned loads would wait for the stores.
HOT void taps_along_x(real tap[TAPS], __global const float *from, long deep, int k, const int is_slope) {
  real row[VECTORS_AROUND];
  UNROLL_ALL for (int n = 0; n < VECTORS_AROUND; ++n) {
    UNROLL_ALL for (int c = 0; c < TAPS; ++c) tap[c] = LOAD(from + n * LANES + c * deep);
    row[n] = interpolate(tap, k, is_slope);
  }
  TAP(0)
  TAP(1)
  TAP(2)
  TAP(3)
  TAP(4)
  TAP(5)
}

#if LANES > 1
#define OF_TWO(n) ((n) % 2 * LANES + (n) / 2)
#define OF_TWO_PAIRS(n) ((n) % 4 / 2 * LANES + (n) / 4 * 2 + (n) % 2)
#define MERGED(a, b, of, n) __builtin_shufflevector(a, b, EACH_LANE(of, n))
#define ORDERED_HALF(half)                                                       \
  {                                                                              \
    const real even = MERGED(by_cell[0], by_cell[1], OF_TWO, half * LANES);      \
    const real odd = MERGED(by_cell[2], by_cell[3], OF_TWO, half * LANES);       \
    row[2 * half] = MERGED(even, odd, OF_TWO_PAIRS, 0);                          \
    row[2 * half + 1] = MERGED(even, odd, OF_TWO_PAIRS, LANES);                  \
  }
#else
#define ORDERED_HALF(half)                                                       \
  {                                                                              \
    row[2 * half] = by_cell[2 * half];                                           \
    row[2 * half + 1] = by_cell[2 * half + 1];                                   \
  }
#endif

// A row of LANES * COARSE_STEP points, in planes.
typedef struct { real at[PLANES * COARSE_STEP]; } points_t;

// Rows of points of a layer, interpolated along z and x: one behind the other along y at nodes.
typedef struct { points_t rows[BAND + TAPS - 1]; } layer_t;

// Interpolates the layer k / COARSE_STEP after the first nodes of a band; or its derivative along axis
// 0 or 2.
HOT void interpolate_layer(layer_t *layer, const coarse_t *coarse, __global const float *node_planes,
                           const band_t *band, int k, const int slope_along) {
  const long along = coarse->nodes[0], plane = node_count(coarse), deep = along * coarse->nodes[1];
  __global const float *corner =
      node_planes + node_of(coarse, band, 0) - BEFORE * (1 + along + deep);
  for (int a = 0; a < band->count + TAPS - 1; ++a)
    for (int p = 0; p < PLANES; ++p) {
      real tap[TAPS], by_cell[COARSE_STEP], *row = layer->rows[a].at + p * COARSE_STEP;
      taps_along_x(tap, corner + a * along + p * plane, deep, k, slope_along == 2);
      UNROLL_ALL for (int i = 0; i < COARSE_STEP; ++i)
        by_cell[i] = interpolate(tap, i, slope_along == 0);
      ORDERED_HALF(0)
      ORDERED_HALF(1)
    }
}

// Interpolates a row j / COARSE_STEP after the nodes b of a layer, or its derivative along y: the n-th
// vector of it.
HOT real interpolate_points(const layer_t *layer, int b, int n, int j, const int is_slope) {
  real tap[TAPS];
  UNROLL_ALL for (int a = 0; a < TAPS; ++a) tap[a] = layer->rows[b + a].at[n];
  return interpolate(tap, j, is_slope);
}

// The same of all rows of a cell b: a column of vectors.
HOT void interpolate_column(real column[COARSE_STEP], const layer_t *layer, int b, int n,
                            const int is_slope) {
  real tap[TAPS];
  UNROLL_ALL for (int a = 0; a < TAPS; ++a) tap[a] = layer->rows[b + a].at[n];
  UNROLL_ALL for (int j = 0; j < COARSE_STEP; ++j) column[j] = interpolate(tap, j, is_slope);
}

// The rows of a band that are in the launch, counted from the first of its first cell.
typedef struct { int first, stop; } rows_t;

// Finds those of layer k.
inline rows_t rows_in_launch(const grid_t *grid, const band_t *band, int k) {
  const int y = band->y * COARSE_STEP - grid->start[1];
  const long layer = (long)grid->ny * (band->z * COARSE_STEP + k - grid->start[2]);
  const long low = max(grid->first / grid->nx - layer, (long)0);
  const long high = min((grid->stop + grid->nx - 1) / grid->nx - layer, (long)grid->ny);
  return (rows_t){(int)max(low - y, (long)0), (int)min(high - y, (long)band->count * COARSE_STEP)};
}

// A row of points of a band, LANES * COARSE_STEP of them. Those from `low` to `high` (not
// included) are in the launch; `position` is that of the first in the launch.
typedef struct {
  int low, high;
  long position;
  vec index;  // in the whole grid, of the first LANES
} row_t;

// The row j of layer k of a band.
inline row_t row_in_launch(const grid_t *grid, const band_t *band, int j, int k) {
  const int x = band->x * COARSE_STEP, y = band->y * COARSE_STEP + j,
            z = band->z * COARSE_STEP + k;
  const long begin =
      grid->nx * (y - grid->start[1] + (long)grid->ny * (z - grid->start[2])) - grid->first;
  const long before = (long)x - grid->start[0];
  const long low = max(max((long)0, -begin), before),
             high = min(min((long)grid->nx, grid->stop - grid->first - begin),
                        before + LANES * COARSE_STEP);
  return (row_t){(int)(low - before), (int)(high - before), begin + before,
                 (vec){TO_REAL(lane_indices() + x), (real)(y), (real)(z)}};
}

// The indices of the n-th LANES of a row.
inline vec indices_in(const row_t *row, int n) {
  return (vec){row->index.x + n * LANES, row->index.y, row->index.z};
}

// Which of them are in the launch, and on its side of all planes.
inline integer launch_mask(const map_t *map, const row_t *row, int n) {
  const integer lane_index = lane_indices() + n * LANES;
  const integer mask = (lane_index >= row->low) & (lane_index < row->high);
  return CUTS ? mask & in_region(&map->cuts, indices_in(row, n)) : mask;
}

// The displacement d, interpolated between nodes, after the limits at a point of the grid: nodes have
// it before them.
inline vec limited_on_grid(const map_t *map, const grid_t *grid, vec index, vec d) {
  return LIMITS ? limited(map, transformed(grid->frame, index), d) : d;
}

// Stores the n-th LANES of a row in a plane, where `mask` is set.
inline void store_in_row(__global float *plane, real value, const row_t *row, int n, integer mask) {
  __global float *to = plane + row->position + n * LANES;
  if (ALL(mask)) {
    STORE(value, to);
    return;
  }
  for (int l = 0; l < LANES; ++l)
    if (LANE_INT(mask, l)) to[l] = LANE(value, l);
}

// The same as interleaved points.
inline void store_points_in_row(__global float *points, vec value, const row_t *row, int n,
                                integer mask) {
  __global float *to = points + 3 * (row->position + n * LANES);
  if (ALL(mask)) {
    store_interleaved(to, value, LANES);
    return;
  }
  for (int l = 0; l < LANES; ++l)
    if (LANE_INT(mask, l)) store_point(to + 3 * l, value, l);
}
