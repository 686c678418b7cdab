// Gradient of an array on a grid by differences, as vtk_mls/queries/vector_fields.py computes it.

#include "types.cl"
#include "sums.cl"

#if !defined(VALUE) || !defined(OFFSET)
#error "VALUE or OFFSET is missing"
#endif

#define LOAD_VALUES(from) TO_SUM(LOAD(from))
#define LOAD_VALUE(from) ((SUM)(*(from)))

// The derivative per index at the i-th of n points, whose neighbors are a stride apart.
#define DEFINE_SLOPE(name, type, load)                                                            \
  inline type name(__global const VALUE *at, OFFSET stride, int i, int n) {                       \
    if (n == 1) return 0;                                                                         \
    if (i == 0 || i == n - 1) {                                                                   \
      const OFFSET inward = i == 0 ? stride : -stride;                                            \
      const type value = load(at);                                                                \
      type rise = load(at + inward) - value;                                                      \
      if (n > 2) rise = 2 * rise - (load(at + 2 * inward) - value) / 2;                           \
      return i == 0 ? rise : -rise;                                                               \
    }                                                                                             \
    const type rise = load(at + stride) - load(at - stride);                                      \
    if (n <= 4 || i == 1 || i == n - 2) return rise / 2;                                          \
    return (8 * rise - (load(at + 2 * stride) - load(at - 2 * stride))) / 12;                     \
  }

DEFINE_SLOPE(slope, SUM, LOAD_VALUE)
DEFINE_SLOPE(slopes, sum_t, LOAD_VALUES)

// A work item computes LANES points of a row; the last one of a row may have fewer.
__kernel EXPLICIT_VECTORS void gradient(
    const slices_t slices, __global const VALUE *restrict values, __global float *restrict result) {
  const int nx = slices.size[0], ny = slices.size[1], nz = slices.size[2];
  const int items = (nx + LANES - 1) / LANES;
  const long item = get_global_id(0), row = item / items;
  if (row >= (long)ny * (slices.stop - slices.start)) return;
  const int i = (int)(item % items) * LANES, lanes = min(LANES, nx - i);
  const int j = (int)(row % ny), k = (int)(row / ny) + slices.start;
  const OFFSET line = nx, slice = line * ny;
  __global const VALUE *at = values + (k - slices.first) * slice + j * line + i;
  sum_t x = 0, y = 0, z = 0;
  if (lanes == LANES) {
    y = slopes(at, line, j, ny);
    z = slopes(at, slice, k, nz);
  } else {
    for (int l = 0; l < lanes; ++l) {
      LANE_SUM(y, l) = slope(at + l, line, j, ny);
      LANE_SUM(z, l) = slope(at + l, slice, k, nz);
    }
  }
  if (i >= 2 && i + LANES <= nx - 2) {
    x = slopes(at, 1, 2, nx);
  } else {
    for (int l = 0; l < lanes; ++l) LANE_SUM(x, l) = slope(at + l, 1, i + l, nx);
  }
  vec along = transformed(slices.to_world, (vec){SUM_TO_REAL(x), SUM_TO_REAL(y), SUM_TO_REAL(z)});
  store_interleaved(result + 3 * (row * nx + i), along, lanes);
}
