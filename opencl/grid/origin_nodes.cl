// First guesses for searches over a grid: the origin x and its changes at nodes, every NODE_STEP-th
// point of the whole grid along each axis. Most searches end at their start. A guess depends on the
// index of its point only: parts are computed like the whole.

// x, and half of its change along i, at an end of a cell. Linear interpolation of the corners'
// predictions with half of their slopes is exact for quadratic functions.
typedef struct { float4 x, by_i; } cell_end_t;

inline cell_end_t cell_end(const nodes_t *nodes, __global const node_t *corner, float b, float c) {
  cell_end_t end = {0, 0};
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j) {
      __global const node_t *node = corner + nodes->nx * (j + nodes->ny * k);
      float share = (j ? b : 1 - b) * (k ? c : 1 - c);
      end.x += share * (node->x + 0.5f * ((b - j) * node->by_j + (c - k) * node->by_k));
      end.by_i += 0.5f * share * node->by_i;
    }
  return end;
}

// The cell of a point, and the relative position in it.
inline integer cell_of(const nodes_t *nodes, vec index, vec *share) {
  const int *first = nodes->first;
  vec at = vec_scale((real)(1.0f / NODE_STEP), index);
  vec cell = {floor(at.x), floor(at.y), floor(at.z)};
  *share = vec_sub(at, cell);
  integer j = TO_INTEGER(cell.y) - first[1] + nodes->ny * (TO_INTEGER(cell.z) - first[2]);
  return TO_INTEGER(cell.x) - first[0] + nodes->nx * j;
}

// The start from nodes, or the affine one where a cut is between the two.
inline start_t on_expected_side(const map_t *map, start_t start, start_t expected) {
  integer is_separated = blocked(&map->cuts, start.x, expected.x);
  start.x = vec_select(start.x, expected.x, is_separated);
  start.slope = select(start.slope, expected.slope, is_separated);
  return start;
}

// The start of searches for the whole-grid points `index`. Neighboring points mostly share cells.
inline start_t start_at(const map_t *map, const nodes_t *nodes, __global const node_t *table,
                        vec index, vec v) {
  const start_t expected = affine_start(map, v);
  start_t start = expected;
  vec share;
  integer cell = cell_of(nodes, index, &share), open = (real)(0) == 0;
  real a = share.x, other = 1 - share.x;
  for (int l = 0; l < LANES; ++l) {
    if (!LANE_INT(open, l)) continue;
    __global const node_t *corner = table + LANE_INT(cell, l);
    float b = LANE(share.y, l), c = LANE(share.z, l), slope = corner->by_i.w;
    integer same = (cell == LANE_INT(cell, l)) & (share.y == b) & (share.z == c);
    open &= !same;
    if (!(slope >= 0)) continue;
    cell_end_t low = cell_end(nodes, corner, b, c), high = cell_end(nodes, corner + 1, b, c);
    vec x = {other * (low.x.x + a * low.by_i.x) + a * (high.x.x - other * high.by_i.x),
             other * (low.x.y + a * low.by_i.y) + a * (high.x.y - other * high.by_i.y),
             other * (low.x.z + a * low.by_i.z) + a * (high.x.z - other * high.by_i.z)};
    start.x = vec_select(start.x, x, same);
    start.slope = select(start.slope, (real)(slope), same);
  }
  return on_expected_side(map, start, expected);
}
