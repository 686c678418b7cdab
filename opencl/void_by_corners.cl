// What the void distances at the corners of cells tell of the void in them; the rules are those of
// vtk_mls/queries/void_cells.py. Build constants: README.md.

#include "types.cl"

#if !defined(HEIGHT) || !defined(DEPTH) || !defined(FAR) || !defined(VOID) || !defined(UNKNOWN) || !defined(TOUCHED)
#error "HEIGHT, DEPTH, FAR, VOID, UNKNOWN or TOUCHED is missing: see README.md"
#endif

typedef struct { real low, high; } range_t;

HOT void join(range_t *a, const range_t *b) {
  a->low = least(a->low, b->low);
  a->high = most(a->high, b->high);
}

// LANES numbers of a row from x on; before it the first, behind it the last. What is not a number is
// as far as can be, which tells nothing.
HOT real load_row(__global const float *row, int x, int count) {
  real found;
  if (x >= 0 && x + LANES <= count) {
    found = LOAD(row + x);
  } else {
    for (int l = 0; l < LANES; ++l) LANE(found, l) = row[clamp(x + l, 0, count - 1)];
  }
  return select((real)(INFINITY), found, found == found);
}

// Cells of a work item: LANES along x, HEIGHT rows of them, in DEPTH layers one after the other. In
// each slice of points it needs the range along y of ROWS rows of cells, one before and one after its
// own, for SHIFTS columns of points, one before and two behind the first of each of its cells.
#define ROWS (HEIGHT + 2)
#define SHIFTS 4
typedef struct { range_t at[ROWS][SHIFTS]; } slice_t;

HOT void load_slice(slice_t *slice, const layers_t *layers, __global const float *values, int x, int y,
                    int z) {
  const int nx = layers->size[0], ny = layers->size[1];
  z = clamp(z - layers->first, 0, layers->there - 1);
  __global const float *plane = values + (long)nx * ny * z;
  for (int shift = 0; shift < SHIFTS; ++shift) {
    range_t before;
    for (int row = 0; row <= ROWS; ++row) {
      __global const float *points = plane + (long)nx * clamp(y + row - 1, 0, ny - 1);
      const real here = load_row(points, x + shift - 1, nx);
      const range_t alone = {here, here};
      if (row > 0) {
        join(&before, &alone);
        slice->at[row - 1][shift] = before;
      }
      before = alone;
    }
  }
}

// Of some cells in a layer their own range; and the largest difference of the corners of a cell among
// them and those beside them in the layer.
typedef struct {
  range_t own[HEIGHT];
  real difference[HEIGHT];
} layer_t;

HOT void look_between(layer_t *layer, const slice_t *below, const slice_t *above) {
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
      const real difference = column[shift].high - column[shift].low;
      // infinite ones have none
      along_x[row] = most(along_x[row], select((real)(INFINITY), difference, difference < INFINITY));
    }
    if (row > 0 && row <= HEIGHT) layer->own[row - 1] = column[1];
  }
  for (int row = 0; row < HEIGHT; ++row)
    layer->difference[row] = most(most(along_x[row], along_x[row + 1]), along_x[row + 2]);
}

HOT integer told(range_t own, real difference, float least_far) {
  const real far = most(FAR * difference, (real)(least_far));
  const integer is_void = own.high < -far, is_full = own.low > far;
  integer bits = select((integer)(UNKNOWN), (integer)(0), is_full);
  bits = select(bits, (integer)(VOID), is_void);
  return bits | select((integer)(0), (integer)(TOUCHED), own.low < 0);
}

KERNEL void void_by_corners(const layers_t layers, __global const float *restrict values,
                            __global uchar *restrict result) {
  const int nx = max(layers.size[0] - 1, 1), ny = max(layers.size[1] - 1, 1);  // cells
  const int strips = (nx + LANES - 1) / LANES, stacks = (ny + HEIGHT - 1) / HEIGHT;
  const long item = get_global_id(0);
  const int x = (int)(item % strips) * LANES, y = (int)(item / strips % stacks) * HEIGHT;
  const int begin = layers.start + (int)(item / strips / stacks) * DEPTH;
  const int end = min(begin + DEPTH, layers.stop);
  const int lanes = min(LANES, nx - x), rows = min(HEIGHT, ny - y);
  if (begin >= end) return;
  slice_t slices[2];
  layer_t found[3];  // of three layers, the one behind the other
  load_slice(&slices[(begin - 1) & 1], &layers, values, x, y, begin - 1);
  for (int z = begin - 1; z <= end; ++z) {
    load_slice(&slices[(z + 1) & 1], &layers, values, x, y, z + 1);
    const layer_t *before = &found[(z + 2) % 3], *here = &found[(z + 3) % 3];
    layer_t *after = &found[(z + 4) % 3];
    look_between(after, &slices[z & 1], &slices[(z + 1) & 1]);
    if (z <= begin) continue;
    for (int row = 0; row < rows; ++row) {
      const real difference =
          most(most(before->difference[row], here->difference[row]), after->difference[row]);
      const integer bits = told(here->own[row], difference, layers.least);
      __global uchar *to = result + x + nx * (y + row + (long)ny * (z - 1 - layers.start));
      for (int l = 0; l < lanes; ++l) to[l] = (uchar)LANE_INT(bits, l);
    }
  }
}
