// Trilinear interpolation: of each point a pair of values along x in each of four rows.

// Passed by address: Oclgrind has no kernel where two floats are returned.
typedef struct { tap_t first, second; } pair_t;

// Values and those behind them, by one load for each two.
#define PAIR(l) vload2(0, values + LANE_OFFSET(from, l))
#define FOUR_PAIRS(l) PAIR(l), PAIR(l + 1), PAIR(l + 2), PAIR(l + 3)
HOT void load_neighbors(pair_t *pair, __global const VALUE *values, offset_t from) {
#if LANES == 1
  pair->first = (TAP)values[from];
  pair->second = (TAP)values[from + 1];
#elif LANES == 16
  typedef GLUE(VALUE, 16) values_t;
  const values_t low = (values_t)(FOUR_PAIRS(0), FOUR_PAIRS(4));
  const values_t high = (values_t)(FOUR_PAIRS(8), FOUR_PAIRS(12));
  const values_t first = (values_t)(low.even, high.even), second = (values_t)(low.odd, high.odd);
  pair->first = TO_TAP(first);
  pair->second = TO_TAP(second);
#else
#if LANES == 2
  const GLUE(VALUE, 4) pairs = (GLUE(VALUE, 4))(PAIR(0), PAIR(1));
#elif LANES == 4
  const GLUE(VALUE, 8) pairs = (GLUE(VALUE, 8))(FOUR_PAIRS(0));
#else
  const GLUE(VALUE, 16) pairs = (GLUE(VALUE, 16))(FOUR_PAIRS(0), FOUR_PAIRS(4));
#endif
  pair->first = TO_TAP(pairs.even);
  pair->second = TO_TAP(pairs.odd);
#endif
}

// The pair of the taps j along y and k along z.
HOT void load_pair(pair_t *pair, const box_t *box, const offsets_t *at, const int is_whole,
                   __global const VALUE *values, int j, int k) {
  if (!is_whole) {
    const offset_t row = at->z[k] + at->y[j];
    pair->first = gathered(values, row + at->x[0]);
    pair->second = gathered(values, row + at->x[1]);
    return;
  }
  __global const VALUE *row = values + k * box->step_z + j * box->step_y;
  if (box->step_x == 1) {
    load_neighbors(pair, row, at->corner);
  } else {
    pair->first = gathered(row, at->corner);
    pair->second = gathered(row + box->step_x, at->corner);
  }
}

HOT sum_t interpolated(const box_t *box, const offsets_t *at, const int is_whole,
                       __global const VALUE *values, const tap_t pivot) {
  sum_t sum = 0;
  UNROLL_ALL for (int k = 0; k < SAMPLE_TAPS; ++k)
    UNROLL_ALL for (int j = 0; j < SAMPLE_TAPS; ++j) {
      pair_t pair;
      load_pair(&pair, box, at, is_whole, values, j, k);
      const sum_t first = box->x.weight[0] * TERM(TO_SUM, TO_LONG, pair.first, pivot);
      const sum_t second = TERM(TO_SUM, TO_LONG, pair.second, pivot);
      const sum_t along_x = fma(box->x.weight[1], second, first);
      sum = fma(box->y.weight[j] * box->z.weight[k], along_x, sum);
    }
  return sum;
}
