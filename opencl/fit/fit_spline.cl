// Splines: G(v) = v + A [1, v] + sum_i c_i phi(sqrt(|v - q_i|^2 + l^2)), phi = -r, r^2 log r or r^3.
//
// `kind_table` has A, by rows of four for 1, x, y and z, l^2, then q and c of each control point; and
// again all these in double. No weight depends on v, so there is no pivot.
//
// Build constants: ORDER 1, 2 or 3; USE_FP64, LANES.

#include "sums.cl"

typedef struct {
  evaluation_point_t point;
  pivot_t pivot;  // without a meaning
} fit_t;

inline void fit_step(const map_t *map, fit_t *fit) {}

typedef struct {
  sum_t x, y, z;
} spline_vec;

#define SPLINE_AFFINE 12
#define SPLINE_POINTS 13
#define SPLINE_TERM 6

// Value i of the table, in the digits of the sums.
inline SUM spline_value(const map_t *map, int i) {
  const int count = SPLINE_POINTS + SPLINE_TERM * map->params.count;
  return WIDEST_VALUE(map->kind_table, count, i);
}

inline spline_vec spline_point(vec v) { return (spline_vec){TO_SUM(v.x), TO_SUM(v.y), TO_SUM(v.z)}; }

// v - q of control point i, and its square + l^2.
HOT spline_vec spline_offset(const map_t *map, int i, spline_vec v, sum_t *square) {
  const int at = SPLINE_POINTS + SPLINE_TERM * i;
  const spline_vec x = {v.x - spline_value(map, at), v.y - spline_value(map, at + 1),
                        v.z - spline_value(map, at + 2)};
  const sum_t softening2 = (sum_t)(spline_value(map, SPLINE_AFFINE));
  *square = fma(x.x, x.x, fma(x.y, x.y, fma(x.z, x.z, softening2)));
  return x;
}

// 1 / sqrt(x) and log(x), finite for x = 0. In double vectors of 2^-126 and more they are Newton's from
// those in float, within 1e-13, and a series within 2e-12; the built-in functions take three times as long.
#if defined(USE_FP64) && LANES > 1
inline sum_t spline_rsqrt(sum_t x) {
  const sum_t y = TO_SUM(fast_rsqrt(fast_max(SUM_TO_REAL(x), (real)(FLT_MIN))));
  return y * fma((SUM)-0.5 * x * y, y, (sum_t)(1.5));
}

inline sum_t spline_log(sum_t x) {
  const real rounded = fast_max(SUM_TO_REAL(x), (real)(FLT_MIN));
  const integer exponent = (AS_INTEGER(rounded) - 0x3f3504f3) >> 23;  // as in fast_log2
  const sum_t f = x * TO_SUM(AS_REAL((127 - exponent) << 23)) - 1;
  sum_t inverse = TO_SUM(1 / (2 + SUM_TO_REAL(f)));
  inverse = inverse * fma(-inverse, 2 + f, (sum_t)(2));
  const sum_t s = f * inverse, t = s * s;  // log(1 + f) = 2 artanh(s)
  sum_t series = 2.0 / 13;
  series = fma(series, t, (sum_t)(2.0 / 11));
  series = fma(series, t, (sum_t)(2.0 / 9));
  series = fma(series, t, (sum_t)(2.0 / 7));
  series = fma(series, t, (sum_t)(2.0 / 5));
  series = fma(series, t, (sum_t)(2.0 / 3));
  series = fma(series, t, (sum_t)(2));
  return fma(series, s, TO_SUM(TO_REAL(exponent)) * M_LN2);
}
#elif defined(USE_FP64)
#define spline_rsqrt(x) rsqrt(fmax(x, (SUM)FLT_MIN))
#define spline_log(x) log(fmax(x, (SUM)FLT_MIN))
#else
#define spline_rsqrt(x) fast_rsqrt(fast_max(x, (real)(FLT_MIN)))
#define spline_log(x) (M_LN2_F * fast_log2(fast_max(x, (real)(FLT_MIN))))
#endif

// phi(r) by the square of r.
inline sum_t spline_phi(sum_t square) {
  if (ORDER == 2) return (SUM)0.5f * square * spline_log(square);
  const sum_t r = square * spline_rsqrt(square);
  return ORDER == 1 ? -r : square * r;
}

// phi'(r) / r by the square of r; 0 in the cone of r.
inline sum_t spline_slope(sum_t square) {
  if (ORDER == 1) return square > 0 ? -spline_rsqrt(square) : (sum_t)(0);
  if (ORDER == 2) return square > 0 ? spline_log(square) + 1 : (sum_t)(0);
  return 3 * square * spline_rsqrt(square);
}

// G(v) - v - mean displacement.
inline vec displacement_of(const map_t *map, const fit_t *fit) {
  const spline_vec v = spline_point(fit->point.v);
  sum_t d[3];
  for (int axis = 0; axis < 3; ++axis) {
    const int at = 4 * axis;
    d[axis] = fma(v.x, (sum_t)(spline_value(map, at + 1)),
                  fma(v.y, (sum_t)(spline_value(map, at + 2)),
                      fma(v.z, (sum_t)(spline_value(map, at + 3)), (sum_t)(spline_value(map, at)))));
  }
  const int count = map->params.count, block = block_of(map);
  for (int start = 0; start < count; start += block) {
    spline_vec sum = {0, 0, 0};
    for (int i = start; i < min(start + block, count); ++i) {
      const int at = SPLINE_POINTS + SPLINE_TERM * i + 3;
      sum_t square;
      spline_offset(map, i, v, &square);
      const sum_t phi = spline_phi(square);
      sum.x = fma(phi, (sum_t)(spline_value(map, at)), sum.x);
      sum.y = fma(phi, (sum_t)(spline_value(map, at + 1)), sum.y);
      sum.z = fma(phi, (sum_t)(spline_value(map, at + 2)), sum.z);
    }
    d[0] += sum.x, d[1] += sum.y, d[2] += sum.z;
  }
  return (vec){SUM_TO_REAL(d[0]), SUM_TO_REAL(d[1]), SUM_TO_REAL(d[2])};
}

// d(G - v)/dv, rows by the component of G.
inline weight_jacobian_t displacement_jacobian(const map_t *map, const fit_t *fit) {
  const spline_vec v = spline_point(fit->point.v);
  sum_t sums[9];
  for (int i = 0; i < 9; ++i) sums[i] = (sum_t)(spline_value(map, i / 3 * 4 + 1 + i % 3));
  for (int i = 0; i < map->params.count; ++i) {
    const int at = SPLINE_POINTS + SPLINE_TERM * i + 3;
    sum_t square;
    const spline_vec x = spline_offset(map, i, v, &square);
    const sum_t slope = spline_slope(square);
    UNROLL_ALL for (int axis = 0; axis < 3; ++axis) {
      const sum_t c = slope * spline_value(map, at + axis);
      sums[3 * axis] = fma(c, x.x, sums[3 * axis]);
      sums[3 * axis + 1] = fma(c, x.y, sums[3 * axis + 1]);
      sums[3 * axis + 2] = fma(c, x.z, sums[3 * axis + 2]);
    }
  }
  weight_jacobian_t jacobian;
  jacobian.d_dx = (mat){{0}};
  for (int i = 0; i < 9; ++i) jacobian.d_dv.a[i] = SUM_TO_REAL(sums[i]);
  return jacobian;
}
