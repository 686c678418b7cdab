#include "map.cl"
#include "grid.cl"
#include "coarse_map.cl"

// Two vectors of values, in turn from one and the other along x.
#if LANES > 1
#define IN_TURN(a, b, part) MERGED(a, b, OF_TWO, (part) * LANES)
#else
#define IN_TURN(a, b, part) ((part) ? (b) : (a))
#endif

// Stores the values from `first` on of a row of `count`, without those before and after it.
inline void store_between(__global float *row, real value, int first, int count) {
  if (first >= 0 && first + LANES <= count) {
    STORE(value, row + first);
    return;
  }
  for (int l = max(0, -first); l < min(LANES, count - first); ++l) row[first + l] = LANE(value, l);
}

// Rows of nodes around a band, interpolated along z, and along x at nodes of the coarse map.
typedef struct { real even, odd; } node_pair_t;
typedef struct { node_pair_t at[BAND + TAPS - 1][PLANES]; } rows_around_t;

#define MIDWAY (COARSE_STEP / 2)  // between nodes, as `interpolate` counts

HOT void interpolate_rows(rows_around_t *rows, const coarse_t *sparse,
                          __global const float *sparse_planes, const band_t *band, const int k) {
  const long along = sparse->nodes[0], deep = along * sparse->nodes[1];
  __global const float *corner =
      sparse_planes + node_of(sparse, band, 0) - BEFORE * (1 + along + deep);
  for (int a = 0; a < band->count + TAPS - 1; ++a)
    for (int p = 0; p < PLANES; ++p) {
      real tap[TAPS];
      taps_along_x(tap, corner + a * along + p * node_count(sparse), deep, k, 0);
      rows->at[a][p] = (node_pair_t){interpolate(tap, 0, 0), interpolate(tap, MIDWAY, 0)};
    }
}

// Stores a row of nodes in a plane, from node x on.
HOT void store_pairs(__global float *row, node_pair_t nodes, int x, int count) {
  store_between(row, IN_TURN(nodes.even, nodes.odd, 0), x, count);
  store_between(row, IN_TURN(nodes.even, nodes.odd, 1), x + LANES, count);
}

// The nodes of a coarse map, interpolated between nodes twice as far apart.
__kernel EXPLICIT_VECTORS void sparse_node(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const coarse_t sparse, __global const float *restrict sparse_planes, const coarse_t coarse,
    __global float *restrict node_planes) {
  band_t band;
  if (!find_band(&sparse, &band)) return;
  const int *size = coarse.nodes, *first = coarse.first_node;
  const int x = 2 * band.x - first[0] + BEFORE, y = 2 * band.y - first[1] + BEFORE;
  for (int k = 0; k < 2; ++k) {
    const int z = 2 * band.z + k - first[2] + BEFORE;
    if (z < 0 || z >= size[2]) continue;
    rows_around_t rows;
    if (k)
      interpolate_rows(&rows, &sparse, sparse_planes, &band, MIDWAY);
    else
      interpolate_rows(&rows, &sparse, sparse_planes, &band, 0);
    for (int b = 0; b < band.count; ++b)
      for (int p = 0; p < PLANES; ++p) {
        __global float *plane = node_planes + p * node_count(&coarse);
        real even[TAPS], odd[TAPS];
        UNROLL_ALL for (int a = 0; a < TAPS; ++a) {
          even[a] = rows.at[b + a][p].even;
          odd[a] = rows.at[b + a][p].odd;
        }
        for (int j = 0; j < 2; ++j) {
          const int row = y + 2 * b + j;
          if (row < 0 || row >= size[1]) continue;
          const node_pair_t nodes =
              j ? (node_pair_t){interpolate(even, MIDWAY, 0), interpolate(odd, MIDWAY, 0)}
                : (node_pair_t){even[BEFORE], odd[BEFORE]};
          store_pairs(plane + size[0] * (row + (long)size[1] * z), nodes, x, size[0]);
        }
      }
  }
}
