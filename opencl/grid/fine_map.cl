// A finer map in cells where the coarse one is inaccurate: nodes every FINE_STEP-th point of the whole
// grid along each axis, and cells between them. Polynomials are those of coarse_map.cl, taken at nodes and
// midway between them only. Records of type coarse_t hold nodes and cells of either map.
//
// A cell has eight places: its first node, and the places midway to its other corners. Those of a fine
// cell are points of the grid, and those of a coarse cell are fine nodes.

enum {
  PLACES = 8,
  PLACE_LANES = LANES < PLACES ? LANES : PLACES  // that share a cell
};

// Number `number` of the cells of a box: its first node, as indices from first_node on.
inline int3 cell_corner(const coarse_t *coarse, int number) {
  const int nx = coarse->cells[0], ny = coarse->cells[1];
  return (int3)(coarse->first_cell[0] - coarse->first_node[0] + number % nx,
                coarse->first_cell[1] - coarse->first_node[1] + number / nx % ny,
                coarse->first_cell[2] - coarse->first_node[2] + number / nx / ny);
}

inline long node_at(const coarse_t *coarse, int3 at) {
  return at.x + coarse->nodes[0] * (at.y + (long)coarse->nodes[1] * at.z);
}

// The place (0 to 7) of each lane of a work item.
inline integer places_of(long first) { return (lane_indices() + (int)(first % PLACES)) % PLACES; }

// The entry of a list of cells for the lanes from `lane` on; past the end the last entry.
inline int listed_cell(const coarse_t *coarse, __global const int *cells, long first, int lane) {
  const long entry = min((first + lane) / PLACES, coarse->listed - 1);
  return cells[coarse->first_listed + entry];
}

// Interpolates `planes` of nodes at the places of a work item in listed cells.
inline void interpolate_places(real values[PLANES], const coarse_t *coarse,
                               __global const float *planes, __global const int *cells, long first,
                               integer place) {
  const long along = coarse->nodes[0], deep = along * coarse->nodes[1], plane = node_count(coarse);
  real weight[3][TAPS];
  for (int axis = 0; axis < 3; ++axis)
    for (int a = 0; a < TAPS; ++a)
      weight[axis][a] = select((real)(a == BEFORE ? 1.0f : 0.0f),
                               (real)(tap_weight[COARSE_STEP / 2][a]), (place >> axis & 1) != 0);
  for (int lane = 0; lane < LANES; lane += PLACE_LANES) {
    const int3 corner = cell_corner(coarse, listed_cell(coarse, cells, first, lane));
    for (int p = 0; p < PLANES; ++p) {
      __global const float *from =
          planes + p * plane + node_at(coarse, corner) - BEFORE * (1 + along + deep);
      real value = 0;
      for (int c = 0; c < TAPS; ++c) {
        real layer = 0;
        UNROLL_TAPS for (int b = 0; b < TAPS; ++b) {
          real row = 0;
          UNROLL_TAPS for (int a = 0; a < TAPS; ++a)
            row = fma(weight[0][a], (real)(from[a + b * along + c * deep]), row);
          layer = fma(weight[1][b], row, layer);
        }
        value = fma(weight[2][c], layer, value);
      }
      values[p] = lane == 0 ? value : select(values[p], value, lane_indices() >= lane);
    }
  }
}
