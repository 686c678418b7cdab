// Segments of curves: moments of weights along a segment, and the few points that have the same.
//
// Along the segment q(t) = q + t along, t from 0 to 1, the weight of a point is
// (e2 / (|q(t) - v|^2 + s^2))^n = (e2 / length^2)^n / ((t - f)^2 + a^2)^n, where v projects to q(f) on
// the line, and a^2 = (squared distance of v from the line + s^2) / length^2. All t are relative to the
// point nearest to v, so that nothing cancels on the curve.
//
// Build constants: SEGMENTS, TWICE_ALPHA, LANES.

#define SEGMENT_POINTS SEGMENTS

// Segments whose place relative to v is kept between the two passes over them; a GPU has too few registers.
#define CACHED_SEGMENTS (LANES > 1 ? 64 : 0)
#define SEGMENTS_IN_CACHE (LANES > 1 ? 64 : 1)
typedef struct { real projection[SEGMENTS_IN_CACHE], off2[SEGMENTS_IN_CACHE]; } cached_segments_t;

// Points for each segment: 2 for degree 1, 3 and 4 for degrees 2 and 3. The sums of the fit need the
// moments up to TOP, those of slopes one more.
#if SEGMENTS == 2
#define TOP 2
#define MOMENTS 4
#elif SEGMENTS == 3
#define TOP 4
#define MOMENTS 6
#else
#define TOP 6
#define MOMENTS 8
#endif
// Distances of v from the middle, in lengths: from DISTANT on the integrals are Gauss-Legendre sums of
// two pairs of nodes, for higher degrees from FAR_SEGMENT on of FAR_PAIRS. Their relative error is below
// 1e-6, for degree 2 1e-8, as its fits magnify it. Fits of degree 3 magnify that of two pairs too much.
// Closed forms lose 2 k digits of the moment k at 10 lengths.
#if SEGMENTS == 2
#define DISTANT(n) (1.2f + 0.9f * (n))
#define FAR_SEGMENT(n) DISTANT(n)
#else
#define DISTANT(n) (SEGMENTS == 3 ? 2.2f + 1.6f * (n) : 1e15f)
#define FAR_SEGMENT(n) 1.25f
#define FAR_PAIRS(n) ((n) == 1 ? 3 : (n) < 4 ? 4 : 5)
#endif
// Distance from a curve, local units, that counts as on it.
#define ON_CURVE 1e-6f
// a^2 and squared distances from a line are at least this, so that all powers are finite.
#define MIN_WIDTH2(n) ((n) == 1 ? 1e-16f : (n) == 2 ? 1e-14f : (n) == 3 ? 1e-12f : 1e-9f)
#define INTEGER_ALPHA (TWICE_ALPHA / 2)

// v relative to a segment: its projection f, the share t of the nearest point, and the squared distances
// of the line, and of that point.
typedef struct {
  real projection, t;
  real off2, d2;
} nearest_t;

HOT nearest_t nearest_by_projection(__global const segment_t *at, real projection, real off2) {
  const real t = clamp01(projection), beyond = projection - t;
  return (nearest_t){projection, t, off2, fma(at->length2 * beyond, beyond, off2)};
}

HOT nearest_t nearest_on_segment(__global const segment_t *at, vec v) {
  const vec along = load3(at->along_q), to = vec_sub(v, load3(at->q));
  const real projection = at->density * dot3(to, along);
  const vec off = vec_madd(-projection, along, to);
  return nearest_by_projection(at, projection, dot3(off, off));
}

// x^n.
HOT real whole_power(real x, int n) {
  return n == 1 ? x : n == 2 ? x * x : n == 3 ? x * x * x : (x * x) * (x * x);
}

// A of arctan(r) = r (1 + A s) for s = r^2, 0 <= r <= 1: relative error of the arctan 2e-7.
HOT real arctan_series(real s) {
  const real s2 = s * s, s4 = s2 * s2;  // pairs of terms, whose sums do not wait for each other
  const real a = fma(s, (real)(0.19992619f), (real)(-0.33333073f));
  const real b = fma(s, (real)(0.10640933f), (real)(-0.14203644f));
  const real c = fma(s, (real)(0.0426915f), (real)(-0.07504293f));
  const real d = fma(s, (real)(0.00284989f), (real)(-0.01606862f));
  return fma(s4, fma(s2, d, c), fma(s2, b, a));
}

// The functions G of `near_integrals`, which are smooth where the closed forms cancel: relative error
// 1e-7 for 0 <= y <= 1/4.
HOT real end_series(real y, int n) {
  const float c3[7] = {0.65130621f,  -1.11605469f, 1.10936832f, -0.90534719f,
                       0.66651256f, -0.428569f,   0.2f};
  const float c4[7] = {1.55386942f,  -2.48969745f, 2.20769056f, -1.52783631f,
                       0.90864884f, -0.44443736f, 0.14285712f};
  real sum = 0;
  UNROLL_ALL for (int i = 0; i < 7; ++i)
    sum = fma(sum, y, (real)(n == 3 ? c3[i] : c4[i]));
  return sum;
}

// By powers j up to n, the integrals k[j] of 1 / ((t - f)^2 + a^2)^j over the segment, and odd[j] of
// (t - f) / ((t - f)^2 + a^2)^j, by closed forms; odd[1] only `with_logarithm`. With low = -f,
// high = 1 - f and P = low high + a^2, k[1] is the angle of (P, a), at which v sees the segment, over
// a. By j, k[j] follows from
//   2 j a^2 K(j + 1) = high / (high^2 + a^2)^j - low / (low^2 + a^2)^j + (2 j - 1) K(j),
// which cancels beyond the ends of the segment, where P > 0; there, with y = a^2 / P^2 and D = P^2 + a^2,
//   K(2) = 1 / D + (1 / D + A / P^2) / (2 P) with A of `arctan_series`,
//   K(3) = (1 + P) / D^2 + G(y) / P^5 and K(4) = ((1 + P)^2 - a^2 / 3) / D^3 + G(y) / P^7.
HOT void power_integrals(real projection, real a2, int n, int with_logarithm, real k[5], real odd[5]) {
  const real low = -projection, high = 1 - projection, both = low + high;
  const real low2 = fma(low, low, a2), high2 = fma(high, high, a2);
  const real p = fma(low, high, a2), p2 = p * p, per_a2 = 1 / a2;
  // one division for 1 / D and 1 / the larger of P^2 and a^2
  const real d = fma(p, p, a2), larger = fast_max(p2, a2), per_both = 1 / (d * larger);
  const real per_d = per_both * larger, square = per_both * d;
  // the angle is a / P (1 + A y), plus pi for P < 0, or pi / 2 - P / a (1 + A / y)
  const integer steep = p2 < a2, ahead = (p > 0) & !steep;
  const real y = fast_min(p2, a2) * square, series = arctan_series(y), per_p = p * square;
  const real right_angles = select(select((real)(2), (real)(0), ahead), (real)(1), steep);
  k[0] = 1;
  odd[0] = 0.5f * both;
  k[1] = fma(fma(series, y, (real)(1)), select(per_p, -per_p, steep),
             1.57079633f * right_angles * sqrt(per_a2));
  if (with_logarithm) odd[1] = 0.34657359f * fast_log2(high2 / low2);
  if (n > 1) {
    const real half_a2 = 0.5f * per_a2, fifth = square * square * per_p;
    const integer beyond = ahead & (y < 0.25f);
    const real direct = half_a2 * fma(2 * a2 - p, per_d, k[1]);
    k[2] = select(direct, fma(0.5f * per_p, fma(series, square, per_d), per_d), ahead);
    odd[2] = 0.5f * both * per_d;
    if (n > 2) {
      const real change = per_d * per_d * fma(a2, 1 + 4 * p, -p * fma((real)(3), p, (real)(1)));
      const real by_k2 = 0.5f * half_a2 * fma((real)(3), k[2], change);
      const real by_series = fma(end_series(y, 3), fifth, (1 + p) * per_d * per_d);
      k[3] = select(by_k2, by_series, beyond);
      odd[3] = 0.25f * both * (low2 + high2) * per_d * per_d;
      if (n > 3) {
        const real cubed = per_d * per_d * per_d;
        const real change = cubed * (high * low2 * low2 * low2 - low * high2 * high2 * high2);
        const real direct = 0.33333333f * half_a2 * fma((real)(5), k[3], change);
        const real series = fma(end_series(y, 4), fifth * square,
                                fma(1 + p, 1 + p, -0.33333333f * a2) * cubed);
        k[4] = select(direct, series, beyond);
        odd[4] = 0.16666667f * both * cubed *
                 fma(high2, high2, fma(high2, low2, low2 * low2));
      }
    }
  }
}

// The integrals f[k] of (t - f)^k / ((t - f)^2 + a^2)^n over the segment, k up to `top`: f[k] of n is
// f[k - 2] of n - 1 less a^2 f[k - 2] of n.
HOT void near_integrals(real projection, real a2, int n, int top, real f[MOMENTS]) {
  const real low = -projection, high = 1 - projection;
  real k[5], odd[5], g[5][MOMENTS];
  power_integrals(projection, a2, n, n == 1 || top > 2, k, odd);
  UNROLL_ALL for (int j = 0; j <= n; ++j) {
    g[j][0] = k[j];
    g[j][1] = odd[j];
  }
  real low_power = low * low, high_power = high * high;
  UNROLL_ALL for (int i = 2; i <= top; ++i) {
    low_power *= low;
    high_power *= high;
    g[0][i] = (high_power - low_power) / (i + 1);
    UNROLL_ALL for (int j = 1; j <= n; ++j) g[j][i] = fma(-a2, g[j][i - 2], g[j - 1][i - 2]);
  }
  UNROLL_ALL for (int i = 0; i <= top; ++i) f[i] = g[n][i];
}

// The Gauss-Legendre rules of 2 to 5 pairs of nodes: offsets from the middle, and weights of a node.
__constant float LEGENDRE_OFFSETS[4][5] = {
    {0.16999052f, 0.43056816f, 0, 0, 0},
    {0.11930959f, 0.33060469f, 0.46623476f, 0, 0},
    {0.09171732f, 0.26276620f, 0.39833324f, 0.48014493f, 0},
    {0.07443717f, 0.21669770f, 0.33970478f, 0.43253168f, 0.48695326f}};
__constant float LEGENDRE_WEIGHTS[4][5] = {
    {0.32607258f, 0.17392742f, 0, 0, 0},
    {0.23395697f, 0.18038079f, 0.08566225f, 0, 0},
    {0.18134189f, 0.15685332f, 0.11119052f, 0.05061427f, 0},
    {0.14776211f, 0.13463336f, 0.10954318f, 0.07472567f, 0.03333567f}};

// The moments of `moments_of` about the middle by a rule, for the squared distance d2 of the middle in
// lengths, and v off the middle by the share `middle`. Sums and differences of a pair of nodes are
// moments of even and of odd order.
HOT void legendre_moments(real middle, real d2, real ratio, float density, int pairs, int slopes,
                          int top, real c, real m[MOMENTS]) {
  UNROLL_ALL for (int i = 0; i <= top; ++i) m[i] = 0;
  UNROLL_ALL for (int i = 0; i < pairs; ++i) {
    const float offset = LEGENDRE_OFFSETS[pairs - 2][i], weight = LEGENDRE_WEIGHTS[pairs - 2][i];
    const real mean = d2 + offset * offset, change = 2 * offset * middle;
    const real low = 1 / (mean + change), high = 1 / (mean - change);
    real w_low = whole_power(ratio * low, INTEGER_ALPHA);
    real w_high = whole_power(ratio * high, INTEGER_ALPHA);
    if (slopes) {
      w_low *= density * low;
      w_high *= density * high;
    }
    const real even = w_high + w_low, odd = w_high - w_low;
    float factor = weight;
    UNROLL_ALL for (int j = 0; j <= top; ++j) {
      m[j] = fma((real)(factor), j % 2 ? odd : even, m[j]);
      factor *= offset;
    }
  }
  UNROLL_ALL for (int i = 0; i <= top; ++i) m[i] *= c;
}

// The moments of `moments_of` about the nearest point, or from FAR_SEGMENT on about the middle.
HOT void close_moments(__global const segment_t *at, const nearest_t *nearest, real middle, real width2,
                       real ratio, int slopes, int top, real c, real m[MOMENTS]) {
  const int n = INTEGER_ALPHA + slopes;
  const real d2 = fma(middle, middle, width2), start = nearest->t - nearest->projection;
  const integer is_far = d2 > FAR_SEGMENT(n) * FAR_SEGMENT(n);
  UNROLL_ALL for (int i = 0; i <= top; ++i) m[i] = 0;
  if (ANY(!is_far)) {
    const real min_width2 = MIN_WIDTH2(n) * max(at->density, 1.0f);
    near_integrals(nearest->projection, fast_max(width2, min_width2), n, top, m);
    // about the nearest point instead of f
    UNROLL_ALL for (int i = 1; i <= top; ++i)
      UNROLL_ALL for (int j = top; j >= i; --j) m[j] = fma(-start, m[j - 1], m[j]);
    real scale = c * whole_power(ratio, INTEGER_ALPHA);
    if (slopes) scale *= at->density;
    UNROLL_ALL for (int i = 0; i <= top; ++i) m[i] *= scale;
  }
#if SEGMENTS > 2
  if (ANY(is_far)) {
    real sums[MOMENTS];
    legendre_moments(middle, d2, ratio, at->density, FAR_PAIRS(n), slopes, top, c, sums);
    UNROLL_ALL for (int i = 0; i <= top; ++i) m[i] = select(m[i], sums[i], is_far);
  }
#endif
}

// The moments m[k] of a segment, k up to `top`, of the weights (e2 / d^2)^alpha; with `slopes`, of
// the weights (e2 / d^2)^alpha / d^2; times c. They are about a share of the length, which is
// returned relative to the nearest point: that point, or farther away the middle.
HOT real moments_of(__global const segment_t *at, const nearest_t *nearest, float smoothing2, real e2,
                    int slopes, int top, real c, real m[MOMENTS]) {
  const int n = INTEGER_ALPHA + slopes;
  const float density = at->density;
  const real width2 = density * (nearest->off2 + smoothing2), ratio = e2 * density;
  const real middle = nearest->projection - 0.5f, d2 = fma(middle, middle, width2);
  const integer is_distant = d2 > DISTANT(n) * DISTANT(n);
  UNROLL_ALL for (int i = 0; i <= top; ++i) m[i] = 0;
  if (ANY(is_distant)) legendre_moments(middle, d2, ratio, density, 2, slopes, top, c, m);
  if (!ALL(is_distant)) {
    real close[MOMENTS];
    close_moments(at, nearest, middle, width2, ratio, slopes, top, c, close);
    UNROLL_ALL for (int i = 0; i <= top; ++i) m[i] = select(close[i], m[i], is_distant);
  }
  return select((real)(0), 0.5f - nearest->t, d2 > FAR_SEGMENT(n) * FAR_SEGMENT(n));
}

#if SEGMENTS == 2
// The same up to 2 about the mean, without slopes: m[1] is 0.
HOT real central_moments(__global const segment_t *at, const nearest_t *nearest, float smoothing2,
                         real e2, real c, real m[MOMENTS]) {
#if INTEGER_ALPHA > 1
  const int n = INTEGER_ALPHA;
  const float density = at->density;
  const real width2 = density * (nearest->off2 + smoothing2), ratio = e2 * density;
  const real middle = nearest->projection - 0.5f, d2 = fma(middle, middle, width2);
  const integer is_distant = d2 > DISTANT(n) * DISTANT(n);
  real mean = 0;
  m[0] = m[2] = 0;
  if (ANY(is_distant)) {
    legendre_moments(middle, d2, ratio, density, 2, 0, 2, c, m);
    mean = m[1] / fast_max(m[0], (real)(1e-30f));
    m[2] = fma(-mean, m[1], m[2]);
    mean += 0.5f - nearest->t;
  }
  if (!ALL(is_distant)) {
    real k[5], odd[5];
    power_integrals(nearest->projection, fast_max(width2, (real)(MIN_WIDTH2(n) * max(density, 1.0f))),
                    n, 0, k, odd);
    const real per_k = 1 / k[n], from_f = odd[n] * per_k, total = k[n] * (c * whole_power(ratio, n));
    const real square = fma(k[n - 1], per_k, -fma(from_f, from_f, width2));
    m[0] = select(total, m[0], is_distant);
    m[2] = select(total * fast_min(fast_max(square, (real)(0)), (real)(0.25f)), m[2], is_distant);
    mean = select(from_f + (nearest->projection - nearest->t), mean, is_distant);
  }
  m[1] = 0;
  return mean;
#else
  // its logarithm would lose digits of the mean
  const real from_nearest = moments_of(at, nearest, smoothing2, e2, 0, 2, c, m);
  const real mean = m[1] / fast_max(m[0], (real)(1e-30f));
  m[2] = fast_max(fma(-mean, m[1], m[2]), (real)(0));
  m[1] = 0;
  return from_nearest + mean;
#endif
}
#endif

// The moments of the weight of a segment: about the mean for degree 1 without slopes.
HOT real weight_moments(__global const segment_t *at, const nearest_t *nearest, float smoothing2,
                        real e2, int slopes, int top, real c, real m[MOMENTS]) {
#if SEGMENTS == 2
  if (!slopes) return central_moments(at, nearest, smoothing2, e2, c, m);
#endif
  return moments_of(at, nearest, smoothing2, e2, slopes, top, c, m);
}

// Points t[i] with weights w[i] that have the moments m of a segment.
typedef struct {
  real t[SEGMENTS], w[SEGMENTS];
} rule_t;

// Mean and standard deviation of the measure with moments `m`.
HOT real mean_of(const real m[MOMENTS], real *sigma) {
  const real per_total = 1 / fast_max(m[0], (real)(1e-30f)), mean = m[1] * per_total;
  *sigma = sqrt(fast_max(fma(-mean, mean, m[2] * per_total), (real)(1e-30f)));
  return mean;
}

#if SEGMENTS == 2
// Two points: the moments up to 2, which determine rotations and affine maps; with `skewed` up to 3,
// for their slopes.
HOT rule_t rule_of(const real m[MOMENTS], int skewed) {
  real sigma;
  const real mean = mean_of(m, &sigma);
  rule_t rule;
  if (!skewed) {
    rule.t[0] = mean - sigma;
    rule.t[1] = mean + sigma;
    rule.w[0] = rule.w[1] = 0.5f * m[0];
    return rule;
  }
  const real per_sigma = 1 / sigma;
  const real third =
      m[3] / fast_max(m[0], (real)(1e-30f)) - mean * fma(3 * sigma, sigma, mean * mean);
  const real g = third * per_sigma * per_sigma * per_sigma;
  const real root = sqrt(fma(g, g, (real)(4)));
  const real high = 0.5f * (fabs(g) + root), low = -1 / high;
  const real a = select(low, -high, g < 0), b = select(high, -low, g < 0);
  rule.t[0] = fma(sigma, a, mean);
  rule.t[1] = fma(sigma, b, mean);
  rule.w[0] = m[0] * b / (b - a);
  rule.w[1] = m[0] - rule.w[0];
  return rule;
}
#else
// Three or four points. Chebyshev's algorithm finds the recurrence of the orthogonal polynomials of
// x = (t - mean) / sigma from the moments; the points are the zeros of the last. They are found between
// those of the one before: two by two, starting with 0.
#define BISECTIONS 16
#define ZERO_STEPS 3  // of Newton's method

// Coefficients of p[k+1] = (x - a[k]) p[k] - b[k] p[k-1]; square norms of p[k].
typedef struct {
  real a[SEGMENTS], b[SEGMENTS], norm[SEGMENTS];
} recurrence_t;

// From the moments up to 2 SEGMENTS - 1.
HOT recurrence_t recurrence_of(const real m[MOMENTS], real mean, real sigma) {
  real c[2 * SEGMENTS];
  const real per_total = 1 / fast_max(m[0], (real)(1e-30f));
  UNROLL_ALL for (int i = 0; i < 2 * SEGMENTS; ++i) c[i] = m[i] * per_total;
  UNROLL_ALL for (int i = 1; i < 2 * SEGMENTS; ++i)
    UNROLL_ALL for (int j = 2 * SEGMENTS - 1; j >= i; --j) c[j] = fma(-mean, c[j - 1], c[j]);
  const real per_sigma = 1 / sigma;
  c[1] = 0;
  c[2] = 1;
  UNROLL_ALL for (int i = 3; i < 2 * SEGMENTS; ++i)  // step by step: the powers may overflow
    UNROLL_ALL for (int j = 0; j < i; ++j) c[i] *= per_sigma;
  recurrence_t result;
  real before[2 * SEGMENTS];
  UNROLL_ALL for (int i = 0; i < 2 * SEGMENTS; ++i) before[i] = 0;
  result.a[0] = result.b[0] = 0;
  result.norm[0] = 1;
  UNROLL_ALL for (int k = 1; k < SEGMENTS; ++k) {
    real last = c[k] / c[k - 1];
    UNROLL_ALL for (int i = k; i < 2 * SEGMENTS - k; ++i) {
      const real next = c[i + 1] - result.a[k - 1] * c[i] - result.b[k - 1] * before[i];
      before[i] = c[i];
      c[i] = next;
    }
    before[k - 1] = c[k - 1];
    c[k] = fast_max(c[k], 1e-3f * before[k - 1]);
    result.a[k] = c[k + 1] / c[k] - last;
    result.b[k] = c[k] / before[k - 1];
    result.norm[k] = c[k];
  }
  return result;
}

// The polynomial of degree `degree` at x, its slope, and the sum of p[k]^2 / norm[k] below the degree.
HOT real polynomial_at(const recurrence_t *r, int degree, real x, real *slope, real *squares) {
  real before = 0, value = 1, slope_before = 0;
  *slope = *squares = 0;
  UNROLL_ALL for (int k = 0; k < degree; ++k) {
    *squares = fma(value, value / r->norm[k], *squares);
    const real next = (x - r->a[k]) * value - r->b[k] * before;
    const real next_slope = value + (x - r->a[k]) * *slope - r->b[k] * slope_before;
    before = value;
    slope_before = *slope;
    value = next;
    *slope = next_slope;
  }
  return value;
}

// The zero between `low` and `high`, where the polynomial changes its sign.
inline real zero_between(const recurrence_t *r, int degree, real low, real high) {
  real slope, squares;
  const integer rises = polynomial_at(r, degree, high, &slope, &squares) > 0;
  for (int i = 0; i < BISECTIONS; ++i) {
    const real middle = 0.5f * (low + high);
    const integer above = (polynomial_at(r, degree, middle, &slope, &squares) > 0) == rises;
    high = select(high, middle, above);
    low = select(middle, low, above);
  }
  real x = 0.5f * (low + high);
  for (int i = 0; i < ZERO_STEPS; ++i) {
    const real value = polynomial_at(r, degree, x, &slope, &squares);
    x = fast_min(fast_max(x - value / slope, low), high);
  }
  return x;
}

#if SEGMENTS == 3
// Three points with the moments up to 4.
HOT rule_t rule_of_four(const real m[MOMENTS]) {
  real sigma;
  const real mean = mean_of(m, &sigma), per_total = 1 / fast_max(m[0], (real)(1e-30f));
  const real m2 = m[2] * per_total, m3 = m[3] * per_total, m4 = m[4] * per_total;
  const real per_sigma = 1 / sigma, square = mean * mean;
  const real g = fma(mean, fma(2 * mean, mean, -3 * m2), m3) * per_sigma * per_sigma * per_sigma;
  real k = fma(mean, fma(3 * mean, fma((real)(2), m2, -square), -4 * m3), m4);
  k = k * per_sigma * per_sigma * per_sigma * per_sigma;
  k = fast_max(k, fma(g, g, (real)(1.01f)));
  const real root = sqrt(fma((real)(4), k, -3 * g * g)), high = 0.5f * (fabs(g) + root);
  const real a = copysign(high, g), b = (g * g - k) / a, w = m[0] / (a - b);
  rule_t rule;
  rule.t[0] = mean;
  rule.t[1] = fma(sigma, a, mean);
  rule.t[2] = fma(sigma, b, mean);
  rule.w[1] = w / a;
  rule.w[2] = -w / b;
  rule.w[0] = m[0] * (1 - 1 / (k - g * g));
  return rule;
}
#endif

HOT rule_t rule_of(const real m[MOMENTS], int skewed) {
#if SEGMENTS == 3
  if (!skewed) return rule_of_four(m);
#endif
  real sigma, zeros[SEGMENTS];
  const real mean = mean_of(m, &sigma);
  const recurrence_t r = recurrence_of(m, mean, sigma);
  real reach = 0;  // all zeros are within
  UNROLL_ALL for (int k = 0; k < SEGMENTS; ++k)
    reach = fast_max(reach, fabs(r.a[k]) + sqrt(r.b[k]) + (k + 1 < SEGMENTS ? sqrt(r.b[k + 1]) : 0));
  zeros[0] = 0;
  UNROLL_ALL for (int degree = 2; degree <= SEGMENTS; ++degree) {
    real roots[SEGMENTS];
    UNROLL_ALL for (int i = 0; i < degree; ++i)
      roots[i] = zero_between(&r, degree, i > 0 ? zeros[i - 1] : -reach,
                              i + 1 < degree ? zeros[i] : reach);
    UNROLL_ALL for (int i = 0; i < degree; ++i) zeros[i] = roots[i];
  }
  rule_t rule;
  UNROLL_ALL for (int i = 0; i < SEGMENTS; ++i) {
    real slope, squares;
    polynomial_at(&r, SEGMENTS, zeros[i], &slope, &squares);
    rule.t[i] = fma(sigma, zeros[i], mean);
    rule.w[i] = m[0] / squares;
  }
  return rule;
}
#endif

// The factors of the matrix of moments m[j + k] = sum of l[j][i] norm[i] l[k][i] over i, with 1 on the
// diagonal of l: t^j is the sum of l[j][i] times polynomials that are orthogonal for the weight of a
// segment, of these square norms.
typedef struct {
  real l[SEGMENTS][SEGMENTS], norm[SEGMENTS];
} factors_t;

// `m` has MOMENTS values: a pointer, as the caller has it from a struct (digit_loss.cl).
HOT factors_t factors_of(const real *m) {
  factors_t result;
#if SEGMENTS == 2  // about the mean
  result.norm[0] = m[0];
  result.norm[1] = m[2];
#else
  UNROLL_ALL for (int k = 0; k < SEGMENTS; ++k) {
    real column[SEGMENTS];
    UNROLL_ALL for (int j = k; j < SEGMENTS; ++j) {
      column[j] = m[j + k];
      UNROLL_ALL for (int i = 0; i < k; ++i)
        column[j] = fma(-result.l[j][i], result.norm[i] * result.l[k][i], column[j]);
    }
    result.norm[k] = fast_max(column[k], (real)(0));
    const real per_norm = 1 / fast_max(column[k], (real)(1e-30f));
    UNROLL_ALL for (int j = k + 1; j < SEGMENTS; ++j) result.l[j][k] = per_norm * column[j];
    result.l[k][k] = 1;
  }
#endif
  return result;
}
