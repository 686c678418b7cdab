// Decides from the void distances at its corners whether a cell is void, by the rules of
// vtk_mls/queries/void_cells.py.

#include "types.cl"

typedef struct { real low, high; } range_t;

HOT void join(range_t *a, const range_t *b) {
  a->low = fast_min(a->low, b->low);
  a->high = fast_max(a->high, b->high);
}

// LANES values of a row from x on; the first and last value continue it. NaN becomes infinite, which
// decides nothing.
HOT real load_row(__global const float *row, int x, int count) {
  real value;
  if (x >= 0 && x + LANES <= count) {
    value = LOAD(row + x);
  } else {
    for (int l = 0; l < LANES; ++l) LANE(value, l) = row[clamp(x + l, 0, count - 1)];
  }
  return select((real)(INFINITY), value, value == value);
}

// A work item computes LANES cells along x in CELL_ROWS rows of CELL_LAYERS layers. In each slice of
// points it needs the range along y of ROWS rows of cells, one before and one after its own, for SHIFTS
// columns of points: one before and two after the first of each of its cells.
enum { ROWS = CELL_ROWS + 2, SHIFTS = 4 };
typedef struct { range_t at[ROWS][SHIFTS]; } slice_t;

HOT void load_slice(slice_t *slice, const layers_t *layers, __global const float *values, int x, int y,
                    int z) {
  const int nx = layers->size[0], ny = layers->size[1];
  z = clamp(z - layers->first, 0, layers->stored - 1);
  __global const float *plane = values + (long)nx * ny * z;
  for (int shift = 0; shift < SHIFTS; ++shift) {
    range_t before;
    for (int row = 0; row <= ROWS; ++row) {
      __global const float *points = plane + (long)nx * clamp(y + row - 1, 0, ny - 1);
      const real value = load_row(points, x + shift - 1, nx);
      const range_t alone = {value, value};
      if (row > 0) {
        join(&before, &alone);
        slice->at[row - 1][shift] = before;
      }
      before = alone;
    }
  }
}

// Cells of a layer: their own range, and the largest difference of the corners of a cell among them and
// their neighbors in the layer.
typedef struct {
  range_t own[CELL_ROWS];
  real difference[CELL_ROWS];
} layer_t;

HOT void set_layer(layer_t *layer, const slice_t *below, const slice_t *above) {
  real along_x[ROWS];
  for (int row = 0; row < ROWS; ++row) {
    range_t column[SHIFTS];
    for (int shift = 0; shift < SHIFTS; ++shift) {
      column[shift] = below->at[row][shift];
      join(&column[shift], &above->at[row][shift]);
    }
    along_x[row] = 0;
    for (int shift = 0; shift + 1 < SHIFTS; ++shift) {
      join(&column[shift], &column[shift + 1]);
      real difference = column[shift].high - column[shift].low;
      // the difference of infinite values is NaN
      difference = select((real)(INFINITY), difference, difference < INFINITY);
      along_x[row] = fast_max(along_x[row], difference);
    }
    if (row > 0 && row <= CELL_ROWS) layer->own[row - 1] = column[1];
  }
  for (int row = 0; row < CELL_ROWS; ++row)
    layer->difference[row] = fast_max(fast_max(along_x[row], along_x[row + 1]), along_x[row + 2]);
}

HOT integer flags_of(range_t own, real difference, const layers_t *layers) {
  const real far = fast_max(layers->far_factor * difference, (real)(layers->min_distance));
  const integer is_void = own.high < -far, is_full = own.low > far;
  integer bits = select((integer)(UNKNOWN), (integer)(0), is_full);
  bits = select(bits, (integer)(VOID), is_void);
  return bits | select((integer)(0), (integer)(TOUCHED), own.low < 0);
}

// Flags of cells: bits of structs.h.
__kernel EXPLICIT_VECTORS void void_by_corners(
    const layers_t layers, __global const float *restrict values, __global uchar *restrict result) {
  const int nx = max(layers.size[0] - 1, 1), ny = max(layers.size[1] - 1, 1);  // cells
  const int strips = (nx + LANES - 1) / LANES, stacks = (ny + CELL_ROWS - 1) / CELL_ROWS;
  const long item = get_global_id(0);
  const int x = (int)(item % strips) * LANES, y = (int)(item / strips % stacks) * CELL_ROWS;
  const int begin = layers.start + (int)(item / strips / stacks) * CELL_LAYERS;
  const int end = min(begin + CELL_LAYERS, layers.stop);
  const int lanes = min(LANES, nx - x), rows = min(CELL_ROWS, ny - y);
  if (begin >= end) return;
  slice_t slices[2];
  layer_t window[3];  // three consecutive layers
  load_slice(&slices[(begin - 1) & 1], &layers, values, x, y, begin - 1);
  for (int z = begin - 1; z <= end; ++z) {
    load_slice(&slices[(z + 1) & 1], &layers, values, x, y, z + 1);
    const layer_t *before = &window[(z + 2) % 3], *current = &window[(z + 3) % 3];
    layer_t *after = &window[(z + 4) % 3];
    set_layer(after, &slices[z & 1], &slices[(z + 1) & 1]);
    if (z <= begin) continue;
    for (int row = 0; row < rows; ++row) {
      const real difference = fast_max(
          fast_max(before->difference[row], current->difference[row]), after->difference[row]);
      const integer bits = flags_of(current->own[row], difference, &layers);
      __global uchar *to = result + x + nx * (y + row + (long)ny * (z - 1 - layers.start));
      for (int l = 0; l < lanes; ++l) to[l] = (uchar)LANE_INT(bits, l);
    }
  }
}
