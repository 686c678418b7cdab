// Values of an array at continuous indices. The rules are those of vtk_mls/sampling.py.
// Build constants: README.md.

#include "types.cl"
#include "sums.cl"

#if !defined(VALUE) || !defined(CAST) || !defined(TAPS) || !defined(OFFSET) || !defined(ARRAY)
#error "VALUE, CAST, TAPS, OFFSET or ARRAY is missing"
#endif

// Of the source, `size` points along the axes, `there` from `first` on are in memory, each of so many
// `components`.
typedef struct { ARRAY } array_t;

#if LANES == 1
#define TO_OFFSET(i) ((OFFSET)(i))
typedef OFFSET offset_t;
#else
#define TO_OFFSET(i) GLUE(GLUE(convert_, OFFSET), LANES)(i)
typedef GLUE(OFFSET, LANES) offset_t;
#endif

#define UNROLL _Pragma("unroll")

// Weights of the taps along one axis at the fraction t: two for linear, four for Catmull-Rom.
inline void tap_weights(real t, real w[TAPS]) {
#if TAPS == 2
  w[0] = 1 - t;
  w[1] = t;
#elif TAPS == 4
  w[0] = 0.5f * t * fma(t, 2 - t, (real)(-1));
  w[1] = 0.5f * fma(t * t, fma((real)(3), t, (real)(-5)), (real)(2));
  w[2] = 0.5f * t * fma(t, fma((real)(-3), t, (real)(4)), (real)(1));
  w[3] = 0.5f * t * t * (t - 1);
#else
  w[0] = 1;
#endif
}

// Along one axis with n points, of which `count` from `first` on are there: taps and weights at x,
// and whether x is inside and on a grid point. A tap without weight is the nearest one instead: it
// must not bring in a NaN or an infinity.
typedef struct {
  integer tap[TAPS], nearest, inside, exact;
  real weight[TAPS];
} axis_t;

inline axis_t axis_at(real x, int n, int first, int count) {
  axis_t axis;
  axis.inside = (x >= -0.5f) & (x <= n - 0.5f);
  x = clamp(select((real)(0), x, axis.inside), 0.0f, (float)(n - 1));
  integer base = TO_INTEGER(x);
  real t = x - TO_REAL(base);
  axis.exact = t == 0;
  axis.nearest = clamp(TO_INTEGER(x + 0.5f), first, first + count - 1) - first;
  tap_weights(t, axis.weight);
  for (int tap = 0; tap < TAPS; ++tap) {
    integer at = clamp(base + (tap - (TAPS - 1) / 2), first, first + count - 1) - first;
    axis.tap[tap] = select(at, axis.nearest, axis.weight[tap] == 0);
  }
  return axis;
}

// What lies between two values in memory: components, those of a row and of a slice.
typedef struct { OFFSET x, y, z; } step_t;

#if TAPS == 2
// Interpolated values, of those from `values` on.
inline sum_t interpolated(const axis_t *x, const axis_t *y, const axis_t *z, step_t step,
                          __global const VALUE *values) {
  sum_t sum = 0;
  UNROLL for (int kk = 0; kk < TAPS; ++kk)
    UNROLL for (int jj = 0; jj < TAPS; ++jj) {
      offset_t row = TO_OFFSET(z->tap[kk]) * step.z + TO_OFFSET(y->tap[jj]) * step.y;
      real wyz = y->weight[jj] * z->weight[kk];
      UNROLL for (int ii = 0; ii < TAPS; ++ii) {
        offset_t from = row + TO_OFFSET(x->tap[ii]) * step.x;
        sum_t tap;
        UNROLL for (int l = 0; l < LANES; ++l) LANE_SUM(tap, l) = (SUM)values[((OFFSET *)&from)[l]];
        sum += TO_SUM(x->weight[ii] * wyz) * tap;
      }
    }
  return sum;
}
#elif TAPS == 4
typedef GLUE(SUM, 4) row_t;

// The same with a vector for each row of taps, which is one load where they are neighbours.
inline sum_t interpolated(const axis_t *x, const axis_t *y, const axis_t *z, step_t step,
                          __global const VALUE *values) {
  sum_t result;
  for (int l = 0; l < LANES; ++l) {
    OFFSET from[4];
    row_t wx, sum = 0;
    UNROLL for (int tap = 0; tap < 4; ++tap) {
      from[tap] = LANE_INT(x->tap[tap], l) * step.x;
      LANE_SUM(wx, tap) = LANE(x->weight[tap], l);
    }
    const bool in_a_row = from[3] - from[0] == 3;
    UNROLL for (int kk = 0; kk < 4; ++kk) {
      __global const VALUE *layer = values + LANE_INT(z->tap[kk], l) * step.z;
      row_t rows = 0;
      UNROLL for (int jj = 0; jj < 4; ++jj) {
        __global const VALUE *row = layer + LANE_INT(y->tap[jj], l) * step.y;
        row_t taps;
        if (in_a_row)
          taps = GLUE(GLUE(convert_, SUM), 4)(vload4(0, row + from[0]));
        else
          for (int tap = 0; tap < 4; ++tap) LANE_SUM(taps, tap) = row[from[tap]];
        rows = fma((row_t)(LANE(y->weight[jj], l)), taps, rows);
      }
      sum = fma((row_t)(LANE(z->weight[kk], l)), rows, sum);
    }
    sum *= wx;
    LANE_SUM(result, l) = (sum.x + sum.y) + (sum.z + sum.w);
  }
  return result;
}
#endif

// `index` holds three planes of `count` indices.
KERNEL void resample(const long count, __global const float *restrict index, const array_t array,
                     const VALUE background, __global const VALUE *restrict values,
                     __global VALUE *restrict result) {
  long first = (long)get_global_id(0) * LANES;
  if (first >= count) return;
  int lanes = (int)min((long)LANES, count - first);
  vec at = load_points(index, count, first);
  axis_t x = axis_at(at.x, array.size[0], array.first[0], array.there[0]);
  axis_t y = axis_at(at.y, array.size[1], array.first[1], array.there[1]);
  axis_t z = axis_at(at.z, array.size[2], array.first[2], array.there[2]);
  integer inside = x.inside & y.inside & z.inside;
  integer exact = x.exact & y.exact & z.exact;
  const int components = array.components;
  const OFFSET line = (OFFSET)array.there[0] * components;
  const step_t step = {components, line, line * array.there[1]};
  __global VALUE *to = result + first * components;
  for (int c = 0; c < components; ++c) {
#if TAPS > 1
    sum_t sum = interpolated(&x, &y, &z, step, values + c);
    for (int l = 0; l < lanes; ++l) to[l * components + c] = CAST(LANE_SUM(sum, l));
    if (!ANY(exact | !inside)) continue;
#endif
    for (int l = 0; l < lanes; ++l) {
      if (!LANE_INT(inside, l)) {
        to[l * components + c] = background;
      } else if (TAPS == 1 || LANE_INT(exact, l)) {  // to the bit
        to[l * components + c] = values[LANE_INT(z.nearest, l) * step.z +
                                        LANE_INT(y.nearest, l) * step.y +
                                        LANE_INT(x.nearest, l) * step.x + c];
      }
    }
  }
}
