// Tricubic interpolation, one point after the other: a vector of values along x in each of 16 rows.

typedef GLUE(TAP, 4) tap_row_t;
typedef GLUE(SUM, 4) row_t;
#if IS_INTEGER64
#define TO_TAP_ROW(x) (x)
#else
#define TO_TAP_ROW(x) GLUE(GLUE(convert_, SUM), 4)(x)
#endif

// The row of the taps j along y and k along z.
HOT tap_row_t row_of(const box_t *box, const offsets_t *at, const int is_whole,
                     __global const VALUE *values, int l, int j, int k) {
  if (!is_whole) {
    __global const VALUE *row = values + LANE_OFFSET(at->z[k], l) + LANE_OFFSET(at->y[j], l);
    return (tap_row_t)((TAP)row[LANE_OFFSET(at->x[0], l)], (TAP)row[LANE_OFFSET(at->x[1], l)],
                       (TAP)row[LANE_OFFSET(at->x[2], l)], (TAP)row[LANE_OFFSET(at->x[3], l)]);
  }
  __global const VALUE *row =
      values + LANE_OFFSET(at->corner, l) + k * box->step_z + j * box->step_y;
  const OFFSET step = box->step_x;
  if (step == 1) return TO_TAP_ROW(vload4(0, row));
  return (tap_row_t)((TAP)row[0], (TAP)row[step], (TAP)row[2 * step], (TAP)row[3 * step]);
}

HOT sum_t interpolated(const box_t *box, const offsets_t *at, const int is_whole,
                       __global const VALUE *values, const tap_t pivot) {
  sum_t result;
  for (int l = 0; l < LANES; ++l) {
    row_t sum = 0;
    UNROLL_ALL for (int k = 0; k < SAMPLE_TAPS; ++k) {
      row_t layer = 0;
      UNROLL_ALL for (int j = 0; j < SAMPLE_TAPS; ++j) {
        const tap_row_t row = row_of(box, at, is_whole, values, l, j, k);
        const row_t terms =
            TERM(convert_double4, convert_long4, row, (tap_row_t)(LANE_TAP(pivot, l)));
        layer = fma((row_t)(LANE_SUM(box->y.weight[j], l)), terms, layer);
      }
      sum = fma((row_t)(LANE_SUM(box->z.weight[k], l)), layer, sum);
    }
    sum *= (row_t)(LANE_SUM(box->x.weight[0], l), LANE_SUM(box->x.weight[1], l),
                   LANE_SUM(box->x.weight[2], l), LANE_SUM(box->x.weight[3], l));
    LANE_SUM(result, l) = (sum.x + sum.y) + (sum.z + sum.w);
  }
  return result;
}
