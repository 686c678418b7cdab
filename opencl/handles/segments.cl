// Segments of curves: integrals of weights along a segment, and the few points that have the same.
//
// Along the segment q(t) = q + t along, t from 0 to 1, the weight of a point is
// (e2 / (|q(t) - v|^2 + s^2))^n = (e2 / length^2)^n / ((t - f)^2 + a^2)^n, with the foot f of v on the
// line and a^2 = (squared distance of v from the line + s^2) / length^2. All t are relative to the
// point nearest to v, so that nothing cancels on the curve.

// Distance of v from the middle, in lengths, from which on the integrals are Gauss-Legendre sums of
// n + 3 nodes. Their relative error is below 5e-7.
#define FAR_SEGMENT 2.5f
// a^2 and squared distances from a line are at least this, so that all powers are finite.
#define LEAST_WIDTH2(n) ((n) == 1 ? 1e-16f : (n) == 2 ? 1e-14f : (n) == 3 ? 1e-12f : 1e-9f)
#define MOMENTS 6
#define INTEGER_ALPHA (TWICE_ALPHA / 2)
#define UNROLL_MOMENTS _Pragma("unroll")

// v as seen from a segment: the foot f, the share t of the nearest point, and the squared distances of
// the line, and of that point.
typedef struct {
  real foot, t;
  real off2, d2;
} nearest_t;

HOT nearest_t nearest_on_segment(__global const segment_t *at, vec v) {
  const vec along = {at->along_q[0], at->along_q[1], at->along_q[2]};
  const vec to = {v.x - at->q[0], v.y - at->q[1], v.z - at->q[2]};
  nearest_t nearest;
  nearest.foot = at->density * dot3(to, along);
  nearest.t = least(most(nearest.foot, (real)(0)), (real)(1));
  const vec off = vec_madd(-nearest.foot, along, to), away = vec_madd(-nearest.t, along, to);
  nearest.off2 = dot3(off, off);
  nearest.d2 = dot3(away, away);
  return nearest;
}

// x^n.
HOT real whole_power(real x, int n) {
  return n == 1 ? x : n == 2 ? x * x : n == 3 ? x * x * x : (x * x) * (x * x);
}

// The angle of (x, y), y > 0, from the x axis: 0 to pi, relative error 2e-7. Also the smaller of |x|
// and y over the larger, and 1 / the larger.
inline real half_turn(real x, real y, real *ratio, real *per_larger) {
  const real size = fabs(x);
  const integer steep = size < y;
  *per_larger = 1 / most(size, y);
  *ratio = least(size, y) * *per_larger;
  const real s = *ratio * *ratio;
  real series = 0.00284989f;
  series = fma(series, s, (real)(-0.01606862f));
  series = fma(series, s, (real)(0.0426915f));
  series = fma(series, s, (real)(-0.07504293f));
  series = fma(series, s, (real)(0.10640933f));
  series = fma(series, s, (real)(-0.14203644f));
  series = fma(series, s, (real)(0.19992619f));
  series = fma(series, s, (real)(-0.33333073f));
  real angle = fma(series * s, *ratio, *ratio);
  angle = select(angle, 1.57079633f - angle, steep);
  return select(angle, 3.14159265f - angle, x < 0);
}

// The functions G of `widths`, which are smooth where the closed forms cancel: relative error 1e-7 for
// 0 <= y <= 1/4.
inline real end_series(real y, int n) {
  const float c2[7] = {0.20741026f,  -0.38642445f, 0.4427476f, -0.44345606f,
                       0.42853117f, -0.39999938f, 0.33333333f};
  const float c3[7] = {0.65130621f,  -1.11605469f, 1.10936832f, -0.90534719f,
                       0.66651256f, -0.428569f,   0.2f};
  const float c4[7] = {1.55386942f,  -2.48969745f, 2.20769056f, -1.52783631f,
                       0.90864884f, -0.44443736f, 0.14285712f};
  real sum = 0;
  UNROLL_MOMENTS for (int i = 0; i < 7; ++i)
    sum = fma(sum, y, (real)(n == 2 ? c2[i] : n == 3 ? c3[i] : c4[i]));
  return sum;
}

// The integrals f[k] of (t - f)^k / ((t - f)^2 + a^2)^n over the segment, k up to `top`, by closed
// forms. With low = -f, high = 1 - f and P = low high + a^2, that for n = 1, k = 0 is the angle at
// which v sees the segment over a. By n, k = 0 follows from
//   2 n a^2 K(n + 1) = high / (high^2 + a^2)^n - low / (low^2 + a^2)^n + (2 n - 1) K(n),
// which cancels beyond the ends of the segment, where P > 0; there, with y = a^2 / P^2 and D = P^2 + a^2,
//   K(2) = 1 / D + G(y) / P^3, K(3) = (1 + P) / D^2 + G(y) / P^5 and
//   K(4) = ((1 + P)^2 - a^2 / 3) / D^3 + G(y) / P^7.
HOT void near_integrals(real foot, real a2, int n, int top, real f[MOMENTS]) {
  const real low = -foot, high = 1 - foot, both = low + high;
  const real low2 = fma(low, low, a2), high2 = fma(high, high, a2);
  const real p = fma(low, high, a2), per_a = rsqrt(a2);
  real ratio, per_larger;
  const real angle = half_turn(p, a2 * per_a, &ratio, &per_larger);
  real k[5], odd[5];  // f[0] and f[1] by n
  k[0] = 1;
  odd[0] = 0.5f * both;
  k[1] = angle * per_a;
  if (n == 1 || top > 2) odd[1] = 0.34657359f * (fast_log2(high2) - fast_log2(low2));
  if (n > 1) {
    const real y = ratio * ratio;
    const real per_d = per_larger * per_larger / (1 + y);  // 1 / (low2 high2)
    const real half_a2 = 0.5f * per_a * per_a;
    const integer beyond = (p > 0) & (y < 0.25f) & (p * p > a2);
    const real cube = per_larger * per_larger * per_larger;
    const real direct = half_a2 * fma(2 * a2 - p, per_d, k[1]);
    k[2] = select(direct, fma(end_series(y, 2), cube, per_d), beyond);
    odd[2] = 0.5f * both * per_d;
    if (n > 2) {
      const real change = per_d * per_d * fma(a2, 1 + 4 * p, -p * fma((real)(3), p, (real)(1)));
      const real direct = 0.5f * half_a2 * fma((real)(3), k[2], change);
      const real fifth = cube * per_larger * per_larger;
      const real series = fma(end_series(y, 3), fifth, (1 + p) * per_d * per_d);
      k[3] = select(direct, series, beyond);
      odd[3] = 0.25f * both * (low2 + high2) * per_d * per_d;
      if (n > 3) {
        const real cubed = per_d * per_d * per_d;
        const real change = cubed * (high * low2 * low2 * low2 - low * high2 * high2 * high2);
        const real direct = 0.33333333f * half_a2 * fma((real)(5), k[3], change);
        const real series = fma(end_series(y, 4), fifth * per_larger * per_larger,
                                fma(1 + p, 1 + p, -0.33333333f * a2) * cubed);
        k[4] = select(direct, series, beyond);
        odd[4] = 0.16666667f * both * cubed *
                 fma(high2, high2, fma(high2, low2, low2 * low2));
      }
    }
  }
  // f[k] of n is f[k - 2] of n - 1 less a^2 f[k - 2] of n
  real g[5][MOMENTS];
  UNROLL_MOMENTS for (int j = 0; j <= n; ++j) {
    g[j][0] = k[j];
    g[j][1] = odd[j];
  }
  real low_power = low * low, high_power = high * high;
  UNROLL_MOMENTS for (int i = 2; i <= top; ++i) {
    low_power *= low;
    high_power *= high;
    g[0][i] = (high_power - low_power) / (i + 1);
    UNROLL_MOMENTS for (int j = 1; j <= n; ++j) g[j][i] = fma(-a2, g[j][i - 2], g[j - 1][i - 2]);
  }
  UNROLL_MOMENTS for (int i = 0; i <= top; ++i) f[i] = g[n][i];
}

// The Gauss-Legendre rules of n + 3 nodes from 0 to 1.
__constant float LEGENDRE_NODES[4][7] = {
    {0.06943184f, 0.33000948f, 0.66999052f, 0.93056816f, 0, 0, 0},
    {0.04691008f, 0.23076534f, 0.50000000f, 0.76923466f, 0.95308992f, 0, 0},
    {0.03376524f, 0.16939531f, 0.38069041f, 0.61930959f, 0.83060469f, 0.96623476f, 0},
    {0.02544604f, 0.12923441f, 0.29707742f, 0.50000000f, 0.70292258f, 0.87076559f, 0.97455396f}};
__constant float LEGENDRE_WEIGHTS[4][7] = {
    {0.17392742f, 0.32607258f, 0.32607258f, 0.17392742f, 0, 0, 0},
    {0.11846344f, 0.23931434f, 0.28444444f, 0.23931434f, 0.11846344f, 0, 0},
    {0.08566225f, 0.18038079f, 0.23395697f, 0.23395697f, 0.18038079f, 0.08566225f, 0},
    {0.06474248f, 0.13985270f, 0.19091503f, 0.20897959f, 0.19091503f, 0.13985270f, 0.06474248f}};

// The moments m[k] about the nearest point of a segment, k up to `top`, of the weights
// (e2 / d^2)^alpha; with `slopes`, of the weights (e2 / d^2)^alpha / d^2.
HOT void moments_of(__global const segment_t *at, const nearest_t *nearest, float smoothing2, real e2,
                    int slopes, int top, real m[MOMENTS]) {
  const int n = INTEGER_ALPHA + slopes;
  const real density = at->density, ratio = e2 * density;
  const real width2 = density * (nearest->off2 + smoothing2), middle = nearest->foot - 0.5f;
  const real start = nearest->t - nearest->foot;
  const integer is_far = fma(middle, middle, width2) > FAR_SEGMENT * FAR_SEGMENT;
  UNROLL_MOMENTS for (int i = 0; i <= top; ++i) m[i] = 0;
  if (ANY(!is_far)) {
    const real least2 = LEAST_WIDTH2(n) * most(density, (real)(1));
    near_integrals(nearest->foot, most(width2, least2), n, top, m);
    // about the nearest point instead of the foot
    UNROLL_MOMENTS for (int i = 1; i <= top; ++i)
      UNROLL_MOMENTS for (int j = top; j >= i; --j) m[j] = fma(-start, m[j - 1], m[j]);
    real scale = whole_power(ratio, INTEGER_ALPHA);
    if (slopes) scale *= density;
    UNROLL_MOMENTS for (int i = 0; i <= top; ++i) m[i] *= scale;
  }
  if (ANY(is_far)) {
    real sums[MOMENTS];
    UNROLL_MOMENTS for (int i = 0; i <= top; ++i) sums[i] = 0;
    UNROLL_MOMENTS for (int i = 0; i < n + 3; ++i) {
      const real t = LEGENDRE_NODES[n - 1][i] - nearest->foot, per_d2 = 1 / fma(t, t, width2);
      real w = LEGENDRE_WEIGHTS[n - 1][i] * whole_power(ratio * per_d2, INTEGER_ALPHA);
      if (slopes) w *= density * per_d2;
      UNROLL_MOMENTS for (int j = 0; j <= top; ++j) {
        sums[j] += w;
        w *= LEGENDRE_NODES[n - 1][i] - nearest->t;
      }
    }
    UNROLL_MOMENTS for (int i = 0; i <= top; ++i) m[i] = select(m[i], sums[i], is_far);
  }
}

// Points t[i] with weights w[i] that have the moments m of a segment.
typedef struct {
  real t[SEGMENTS], w[SEGMENTS];
} rule_t;

// Mean and standard deviation of the measure with moments `m`.
HOT real mean_of(const real m[MOMENTS], real *sigma) {
  const real per_total = 1 / most(m[0], (real)(1e-30f)), mean = m[1] * per_total;
  *sigma = sqrt(most(fma(-mean, mean, m[2] * per_total), (real)(1e-30f)));
  return mean;
}

#if SEGMENTS == 2
// Two points: the moments up to 2, which determine rotations and affine maps; with `skewed` up to 3,
// for their slopes.
#define TOP 2
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
  const real third = m[3] / most(m[0], (real)(1e-30f)) - mean * fma(3 * sigma, sigma, mean * mean);
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
// Three points: the moments up to 4; with `skewed` up to 5, as the eigenvalues of the matrix of the
// recurrence of the orthogonal polynomials 1, x, x^2 - g x - 1, x = (t - mean) / sigma.
#define TOP 4
HOT rule_t rule_of(const real m[MOMENTS], int skewed) {
  real sigma;
  const real mean = mean_of(m, &sigma), per_total = 1 / most(m[0], (real)(1e-30f));
  const real m2 = m[2] * per_total, m3 = m[3] * per_total, m4 = m[4] * per_total;
  const real per_sigma = 1 / sigma, per_square = per_sigma * per_sigma, square = mean * mean;
  const real g = fma(mean, fma(2 * mean, mean, -3 * m2), m3) * per_square * per_sigma;
  real k = fma(mean, fma(3 * mean, fma((real)(2), m2, -square), -4 * m3), m4);
  k = most(k * per_square * per_square, fma(g, g, (real)(1.01f)));
  rule_t rule;
  if (!skewed) {
    const real root = sqrt(fma((real)(4), k, -3 * g * g)), high = 0.5f * (fabs(g) + root);
    const real a = copysign(high, g), b = (g * g - k) / a;
    rule.t[0] = mean;
    rule.t[1] = fma(sigma, a, mean);
    rule.t[2] = fma(sigma, b, mean);
    rule.w[1] = m[0] / (a * (a - b));
    rule.w[2] = m[0] / (b * (b - a));
    rule.w[0] = m[0] * (1 - 1 / (k - g * g));
    return rule;
  }
  const real fifth = fma(mean, fma(mean, fma(mean, fma(4 * mean, mean, -10 * m2), 10 * m3), -5 * m4),
                         m[5] * per_total) * per_square * per_square * per_sigma;
  const real norm = k - g * g - 1, last = (fifth - 2 * g * k + g * g * g) / norm;
  // eigenvalues of (0, 1, 0; 1, g, s; 0, s, last) with s^2 = norm
  const real center = (g + last) * 0.33333333f, x = -center, y = g - center, z = last - center;
  const real size2 = fma(x, x, fma(y, y, fma(z, z, 2 * (1 + norm)))) * 0.16666667f;
  const real size = sqrt(size2);
  const real det = x * fma(y, z, -norm) - z;
  const real cosine = 0.5f * det / (size2 * size);
  const real angle = acos(least(most(cosine, (real)(-1)), (real)(1))) * 0.33333333f;
  for (int i = 0; i < 3; ++i) {
    const real at = fma(2 * size, cos(angle + 2.0943951f * i), center);
    const real second = fma(at, at - g, (real)(-1));
    rule.t[i] = fma(sigma, at, mean);
    rule.w[i] = m[0] / fma(at, at, fma(second, second / norm, (real)(1)));
  }
  return rule;
}
#endif
