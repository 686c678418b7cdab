#include "map.cl"
#include "grid.cl"
#include "coarse_map.cl"

// Two vectors of values, in turn from one and the other along x.
#if LANES > 1
#define IN_TURN(a, b, half) MERGED(a, b, OF_TWO, (half) * LANES)
#else
#define IN_TURN(a, b, half) ((half) ? (b) : (a))
#endif

// Stores the values from `first` on of a row of `count`, without those before and after it.
inline void store_between(__global float *row, real value, int first, int count) {
  if (first >= 0 && first + LANES <= count) {
    STORE(value, row + first);
    return;
  }
  for (int l = max(0, -first); l < min(LANES, count - first); ++l) row[first + l] = LANE(value, l);
}

// Places in a sparse cell: those of nodes at 0 and 1/2 along each axis, of middles at 1/4 and 3/4.
#define PLACES 2
#define UNROLL_PLACES _Pragma("unroll")

// Rows of nodes around a band, interpolated along z and x.
typedef struct { real at[BAND + TAPS - 1][PLANES][PLACES]; } rows_around_t;

// Interpolates at the place `place` / 4 along z.
HOT void interpolate_rows(rows_around_t *rows, const coarse_t *sparse,
                          __global const float *sparse_planes, const band_t *band, const int place) {
  const long along = sparse->nodes[0], deep = along * sparse->nodes[1];
  __global const float *corner =
      sparse_planes + node_of(sparse, band, 0) - BEFORE * (1 + along + deep);
  for (int a = 0; a < band->count + TAPS - 1; ++a)
    UNROLL_PLACES for (int p = 0; p < PLANES; ++p) {
      real tap[TAPS];
      taps_along_x(tap, corner + a * along + p * node_count(sparse), deep, place, 0);
      UNROLL_PLACES for (int i = 0; i < PLACES; ++i)
        rows->at[a][p][i] = interpolate(tap, place % 2 + 2 * i, 0);
    }
}

// Stores the places along y of these rows in planes of `size` values, the first of a band at x, y, z.
HOT void store_rows(__global float *planes, const int *size, const rows_around_t *rows,
                    const band_t *band, int x, int y, int z, const int place) {
  for (int b = 0; b < band->count; ++b)
    UNROLL_PLACES for (int p = 0; p < PLANES; ++p) {
      real tap[PLACES][TAPS];
      UNROLL_TAPS for (int a = 0; a < TAPS; ++a)
        UNROLL_PLACES for (int i = 0; i < PLACES; ++i) tap[i][a] = rows->at[b + a][p][i];
      UNROLL_PLACES for (int j = 0; j < PLACES; ++j) {
        const int row = y + PLACES * b + j;
        if (row < 0 || row >= size[1]) continue;
        const real even = interpolate(tap[0], place % 2 + 2 * j, 0);
        const real odd = interpolate(tap[1], place % 2 + 2 * j, 0);
        __global float *to = planes + size[0] * (row + size[1] * (z + (long)size[2] * p));
        store_between(to, IN_TURN(even, odd, 0), x, size[0]);
        store_between(to, IN_TURN(even, odd, 1), x + LANES, size[0]);
      }
    }
}

// The nodes of a coarse map, and the middles of its cells, interpolated between nodes twice as far apart.
__kernel EXPLICIT_VECTORS void sparse_node(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const coarse_t sparse, __global const float *restrict sparse_planes, const coarse_t coarse,
    __global float *restrict node_planes, __global float *restrict middles) {
  band_t band;
  if (!find_band(&sparse, &band)) return;
  UNROLL_PLACES for (int place = 0; place < 2 * PLACES; ++place) {
    const int is_middle = place % 2, before = is_middle ? 0 : BEFORE;
    const int *size = is_middle ? coarse.cells : coarse.nodes;
    const int *first = is_middle ? coarse.first_cell : coarse.first_node;
    const int z = PLACES * band.z + place / 2 - first[2] + before;
    if (z < 0 || z >= size[2]) continue;
    rows_around_t rows;
    interpolate_rows(&rows, &sparse, sparse_planes, &band, place);
    store_rows(is_middle ? middles : node_planes, size, &rows, &band,
               PLACES * band.x - first[0] + before, PLACES * band.y - first[1] + before, z, place);
  }
}
