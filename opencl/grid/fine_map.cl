// A finer map in cells where the coarse one is inaccurate: nodes every FINE_STEP-th point of the whole
// grid along each axis, and cells between them. Polynomials are those of coarse_map.cl, taken at nodes and
// midway between them only. Records of type coarse_t hold nodes and cells of either map.
//
// A cell has eight places: its first node, and the places midway to its other corners. Those of a fine
// cell are points of the grid, and those of a coarse cell are fine nodes.

enum { PLACES = 8 };

// The first node of a cell of a box, as indices from first_node on.
inline int3 cell_corner(const coarse_t *coarse, int cell) {
  const int nx = coarse->cells[0], ny = coarse->cells[1];
  return (int3)(coarse->first_cell[0] - coarse->first_node[0] + cell % nx,
                coarse->first_cell[1] - coarse->first_node[1] + cell / nx % ny,
                coarse->first_cell[2] - coarse->first_node[2] + cell / nx / ny);
}

inline long node_at(const coarse_t *coarse, int3 at) {
  return at.x + coarse->nodes[0] * (at.y + (long)coarse->nodes[1] * at.z);
}

// Entry `at` of a list of cells; past the end the last one.
inline int listed_cell(const coarse_t *coarse, __global const int *cells, long at) {
  return cells[coarse->first_listed + min(at, coarse->listed - 1)];
}

// A row of nodes along x from two before a cell on, with two more than it needs, interpolated at places
// midway along y and z, or not.
HOT float8 row_of(__global const float *from, long along, long deep, int midway_y, int midway_z) {
  __constant const float *weight = tap_weight[COARSE_STEP / 2];
  if (!midway_z) from += BEFORE * deep;
  if (!midway_y) from += BEFORE * along;
  if (!midway_y && !midway_z) return vload8(0, from);
  float8 sum = 0;
  if (midway_y != midway_z) {
    const long step = midway_y ? along : deep;
    UNROLL_ALL for (int a = 0; a < TAPS; ++a)
      sum = fma((float8)(weight[a]), vload8(0, from + a * step), sum);
    return sum;
  }
  for (int c = 0; c < TAPS; ++c) {
    float8 layer = 0;
    UNROLL_ALL for (int b = 0; b < TAPS; ++b)
      layer = fma((float8)(weight[b]), vload8(0, from + b * along + c * deep), layer);
    sum = fma((float8)(weight[c]), layer, sum);
  }
  return sum;
}

// Interpolates along a row; weights are the same from both ends.
HOT float value_in(float8 row, int midway_x) {
  __constant const float *weight = tap_weight[COARSE_STEP / 2];
  return midway_x ? weight[0] * (row.s0 + row.s5) + weight[1] * (row.s1 + row.s4) +
                        weight[2] * (row.s2 + row.s3)
                  : row.s2;
}

// Interpolates `planes` of nodes at LANES places of listed cells, from place `first` of all on.
inline void interpolate_places(real values[PLANES], const coarse_t *coarse,
                               __global const float *planes, __global const int *cells, long first) {
  const long along = coarse->nodes[0], deep = along * coarse->nodes[1], plane = node_count(coarse);
  __global const float *from = planes;
  for (int p = 0; p < PLANES; ++p) {
    float8 row;
    for (int l = 0; l < LANES; ++l) {
      const int place = (int)((first + l) % PLACES);
      if (l == 0 || place == 0) {
        const int cell = listed_cell(coarse, cells, (first + l) / PLACES);
        from = planes + p * plane + node_at(coarse, cell_corner(coarse, cell)) -
               BEFORE * (1 + along + deep);
      }
      if (l == 0 || place % 2 == 0) row = row_of(from, along, deep, place >> 1 & 1, place >> 2);
      LANE(values[p], l) = value_in(row, place & 1);
    }
  }
}
