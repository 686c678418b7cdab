// Images of distances, masks and faces: values at the points of a grid, linear between them. Images of
// faces have the normal after each distance.

#ifndef QUADS  // regions and limits include this file

// Quads: four values of each lane, as they are in memory; vector l has those of the lanes l, l + 4, ...
// They are interpolated before values of all lanes are put together, which takes fewer shuffles.
#if LANES < 4
#define QUADS LANES
typedef float4 quad_t;
#define BLOCKS(of, l) of(l)
#else
#if LANES == 4
#define BLOCKS(of, l) of(l)
#elif LANES == 8
#define BLOCKS(of, l) of(l), of((l) + 4)
#else
#define BLOCKS(of, l) of(l), of((l) + 4), of((l) + 8), of((l) + 12)
#endif
#define QUADS 4
typedef real quad_t;
#define SAME_LANE(n) ((n) % LANES / 4 * 4 + (n) / LANES)
#define ZIP(n, from) ((n) / 4 * 4 + (n) % 4 / 2 + (from) + (n) % 2 * LANES)
#define ZIP_LOW(n) ZIP(n, 0)
#define ZIP_HIGH(n) ZIP(n, 2)
#define HALF_OF_OCT(n, from) ((n) / 4 % 2 * LANES + (n) / 8 * 8 + (n) % 4 + (from))
#define LOW_HALF(n) HALF_OF_OCT(n, 0)
#define HIGH_HALF(n) HALF_OF_OCT(n, 4)
#endif

// The four values at `from` + `first`.
HOT void load_quads(__global const float *from, integer first, quad_t quads[QUADS]) {
#define QUAD_AT(l) vload4(0, from + LANE_INT(first, l))
  UNROLL_ALL for (int l = 0; l < QUADS; ++l) quads[l] = (quad_t)(BLOCKS(QUAD_AT, l));
#undef QUAD_AT
}

// The four values at `from` + `first`, and the next four.
HOT void load_two_quads(__global const float *from, integer first, quad_t low[QUADS],
                        quad_t high[QUADS]) {
#if LANES < 8
  load_quads(from, first, low);
  load_quads(from + 4, first, high);
#else
  // fewer and longer loads than with load_quads()
  real octs[8];
#define OCT_AT(l) vload8(0, from + LANE_INT(first, l))
#if LANES == 8
  UNROLL_ALL for (int l = 0; l < 8; ++l) octs[l] = OCT_AT(l);
#else
  UNROLL_ALL for (int l = 0; l < 8; ++l) octs[l] = (real)(OCT_AT(l), OCT_AT(l + 8));
#endif
#undef OCT_AT
  UNROLL_ALL for (int l = 0; l < 4; ++l) {
    low[l] = __builtin_shufflevector(octs[l], octs[l + 4], EACH_LANE(LOW_HALF, 0));
    high[l] = __builtin_shufflevector(octs[l], octs[l + 4], EACH_LANE(HIGH_HALF, 0));
  }
#endif
}

// Two values at `from` + `first`, and two `row` values farther.
HOT void load_pairs(__global const float *from, int row, integer first, quad_t quads[QUADS]) {
#define PAIRS_AT(l) \
  vload2(0, from + LANE_INT(first, l)), vload2(0, from + row + LANE_INT(first, l))
  UNROLL_ALL for (int l = 0; l < QUADS; ++l) quads[l] = (quad_t)(BLOCKS(PAIRS_AT, l));
#undef PAIRS_AT
}

#if LANES < 4
// A value of each lane, four times.
HOT void to_quads(real a, quad_t quads[QUADS]) {
  UNROLL_ALL for (int l = 0; l < LANES; ++l) quads[l] = LANE(a, l);
}

// The four values as vectors of lanes.
HOT void from_quads(const quad_t quads[QUADS], real values[4]) {
  UNROLL_ALL for (int l = 0; l < LANES; ++l) {
    LANE(values[0], l) = quads[l].x;
    LANE(values[1], l) = quads[l].y;
    LANE(values[2], l) = quads[l].z;
    LANE(values[3], l) = quads[l].w;
  }
}
#else
HOT void to_quads(real a, quad_t quads[QUADS]) {
  quads[0] = __builtin_shufflevector(a, a, EACH_LANE(SAME_LANE, 0));
  quads[1] = __builtin_shufflevector(a, a, EACH_LANE(SAME_LANE, LANES));
  quads[2] = __builtin_shufflevector(a, a, EACH_LANE(SAME_LANE, 2 * LANES));
  quads[3] = __builtin_shufflevector(a, a, EACH_LANE(SAME_LANE, 3 * LANES));
}

HOT real zip_low(real a, real b) { return __builtin_shufflevector(a, b, EACH_LANE(ZIP_LOW, 0)); }
HOT real zip_high(real a, real b) { return __builtin_shufflevector(a, b, EACH_LANE(ZIP_HIGH, 0)); }

HOT void from_quads(const quad_t quads[QUADS], real values[4]) {
  const real a = zip_low(quads[0], quads[2]), b = zip_low(quads[1], quads[3]),
             c = zip_high(quads[0], quads[2]), d = zip_high(quads[1], quads[3]);
  values[0] = zip_low(a, b);
  values[1] = zip_high(a, b);
  values[2] = zip_low(c, d);
  values[3] = zip_high(c, d);
}
#endif

// The cell of an index in a grid of `size` points, limited to it, and the place in the cell.
typedef struct { integer first; vec share; } image_cell_t;

inline image_cell_t image_cell(__global const int *size, vec index) {
  const integer i = min(TO_INTEGER(index.x), (integer)(size[0] - 2)),
                j = min(TO_INTEGER(index.y), (integer)(size[1] - 2)),
                k = min(TO_INTEGER(index.z), (integer)(size[2] - 2));
  return (image_cell_t){i + size[0] * (j + size[1] * k),
                        {index.x - TO_REAL(i), index.y - TO_REAL(j), index.z - TO_REAL(k)}};
}

// The value in a cell, and its change per step.
HOT real image_value(__global const float *values, __global const int *size, image_cell_t cell,
                     vec *slope) {
  const int row = size[0], layer = size[0] * size[1];
  quad_t low[QUADS], high[QUADS], share_z[QUADS];
  load_pairs(values, row, cell.first, low);
  load_pairs(values + layer, row, cell.first, high);
  to_quads(cell.share.z, share_z);
  UNROLL_ALL for (int l = 0; l < QUADS; ++l) {
    high[l] -= low[l];
    low[l] = fma(share_z[l], high[l], low[l]);
  }
  real at[4], z[4];
  from_quads(low, at);
  from_quads(high, z);
  const vec share = cell.share;
  const real x0 = at[1] - at[0], x1 = at[3] - at[2], z0 = fma(share.x, z[1] - z[0], z[0]),
             z1 = fma(share.x, z[3] - z[2], z[2]), first = fma(share.x, x0, at[0]);
  slope->x = fma(share.y, x1 - x0, x0);
  slope->y = fma(share.x, x1, at[2]) - first;
  slope->z = fma(share.y, z1 - z0, z0);
  return fma(share.y, slope->y, first);
}

// A distance and a normal, and their changes per step.
typedef struct {
  real value;
  vec slope, normal;
  mat turn;
} distance_t;

// The distance and the normal in a cell.
inline distance_t distance_at(__global const float *values, __global const int *size,
                              image_cell_t cell) {
  distance_t at;
  for (int l = 0; l < LANES; ++l) {
    const trilinear_t in_cell =
        trilinear(values + 4 * LANE_INT(cell.first, l), size[0], size[0] * size[1],
                  LANE(cell.share.x, l), LANE(cell.share.y, l), LANE(cell.share.z, l));
    const float4 x = in_cell.by_x, y = in_cell.by_y, z = in_cell.by_z;
    LANE(at.value, l) = in_cell.value.x;
    set_lane(&at.normal, l, in_cell.value.yzw);
    set_lane(&at.slope, l, (float3)(x.x, y.x, z.x));
    set_mat_lane(&at.turn, l, x.yzw, y.yzw, z.yzw);
  }
  return at;
}

// The continuous index of a local v.
inline vec index_in_image(__global const float *to_index, vec v) {
  float transform[12];
  UNROLL_ALL for (int i = 0; i < 12; ++i) transform[i] = to_index[i];
  return transformed(transform, v);
}

// The index limited to the grid, whose last point has the index `last`; `beyond` is what was taken off.
inline vec limited_index(vec last, vec index, vec *beyond) {
  const vec inside = {fast_min(fast_max(index.x, (real)(0)), last.x),
                      fast_min(fast_max(index.y, (real)(0)), last.y),
                      fast_min(fast_max(index.z, (real)(0)), last.z)};
  *beyond = vec_sub(index, inside);
  return inside;
}

inline vec last_index(__global const int *size) {
  return (vec){size[0] - 1, size[1] - 1, size[2] - 1};
}

// Slopes per index as slopes per local unit.
inline vec by_index(__global const float *to_index, vec slope) {
  return (vec){to_index[0] * slope.x + to_index[1] * slope.y + to_index[2] * slope.z,
               to_index[3] * slope.x + to_index[4] * slope.y + to_index[5] * slope.z,
               to_index[6] * slope.x + to_index[7] * slope.y + to_index[8] * slope.z};
}
#endif
