// The affine and polynomial kinds, Eq. 23 to 26: p - q is fitted by weighted orthogonal polynomials.
//
// The elimination loses twice as many digits as the fit where a few control points outweigh all
// others (a large alpha, an isolated pair) or hardly determine the fit: there the host sets USE_FP64.
// Sums in double take twice as long as in float. So all points are fitted in float. Where that is too
// inexact, displacements are refined in float, and what is still too inexact is fitted again in double.
// A lane takes the result that its own estimate asks for.

#include "basis.cl"

#define GRAM_SIZE (FUNCTIONS * (FUNCTIONS + 1) / 2)
#define AT(i, j) ((i) * ((i) + 1) / 2 + (j))  // j <= i
#define VANISHING (sizeof(SUM) == sizeof(float) ? 1e-6f : 1e-13f)
#define GROUP 4  // control points summed at once, with one pass of the sums through memory

// Three functions fit the registers; unrolling more only lengthens the build.
#if FUNCTIONS == 3
#define UNROLL UNROLL_ALL
#else
#define UNROLL
#endif
// The sums of a segment, a point at a time, gain a tenth by it.
#if FUNCTIONS <= 9
#define UNROLL_SEGMENT UNROLL_ALL
#else
#define UNROLL_SEGMENT
#endif

// Number of functions that the control points determine; as a constant for three.
inline int functions_of(const map_t *map) { return FUNCTIONS == 3 ? 3 : map->params.rank; }

// The basis functions at a control point, which follow the coefficients in the table.
inline __global const float *values_at(const map_t *map, int i) {
  return map->kind_table + (long)(FUNCTIONS + i) * FUNCTIONS;
}

#define REGION_SIZE (4 * FUNCTIONS + GRAM_SIZE)

// The moments of the functions f over the proxies of a region, which follow the means in the table: f
// at the mean of the proxies, the lower triangle of the means of f f^T, and the means of f (p - q)^T,
// both about their means. Then, for double, their rounding errors.
inline __global const float *moments_of_region(const map_t *map, int i) {
  return values_at(map, map->params.count + 1) + (long)i * 2 * REGION_SIZE;
}

// The basis functions at the pivot k.
inline __global const float *values_at_pivot(const map_t *map, int k) {
  if (is_region(map, k)) return moments_of_region(map, k);
  return values_at(map, min(k, map->params.count));
}

// The basis functions less those at k, at a point q of a segment relative to k.
inline void functions_along(const map_t *map, const pivot_t *pivot, vec q, real f[FUNCTIONS]) {
  real m[MONOMIALS];
  monomial_differences(q, vec_add(q, pivot->q), pivot->q, m);
  combine(map->kind_table, functions_of(map), m, f);
}

// The basis functions along a segment as powers of the share t of its length: coefficients of 1, t,
// ..., FUNCTIONS each, which follow the moments of regions in the table.
inline __global const float *powers_along(const map_t *map, int i) {
  const long regions = REGIONS ? (long)map->params.region_count * 2 * REGION_SIZE : 0;
  return values_at(map, map->params.count + 1) + regions +
         (long)(i - map->params.count) * SEGMENT_POINTS * FUNCTIONS;
}

// Function j along a segment, less that at k, by powers of t about the share along->t of its length, from
// those about its start. In lanes where it `is_pivot`, k is `from_nearest` before along->t, and nothing
// cancels; `has_pivot` is a constant: whether there are such lanes.
HOT void set_powers(real c[SEGMENT_POINTS], __global const float *powers, int j, real f_k,
                    const placed_segment_t *along, integer is_pivot, real from_nearest, const int has_pivot) {
  c[0] = powers[j] - f_k;
  UNROLL_ALL for (int k = 1; k < SEGMENT_POINTS; ++k) c[k] = powers[k * FUNCTIONS + j];
  UNROLL_ALL for (int k = 0; k + 1 < SEGMENT_POINTS; ++k)
    UNROLL_ALL for (int l = SEGMENT_POINTS - 2; l >= k; --l) c[l] = fma(along->t, c[l + 1], c[l]);
  if (has_pivot) {
    real change = c[SEGMENT_POINTS - 1];
    UNROLL_ALL for (int k = SEGMENT_POINTS - 2; k > 0; --k) change = fma(-from_nearest, change, c[k]);
    c[0] = select(c[0], from_nearest * change, is_pivot);
  }
}

// The basis functions at k where it is on a segment; a pointer as in digit_loss.cl.
inline void functions_on_segments(const map_t *map, const pivot_t *pivot, real *f_k) {
  for (int l = 0; l < LANES; ++l) {
    if (LANE_INT(pivot->k, l) < map->params.count) continue;
    __global const float *powers = powers_along(map, LANE_INT(pivot->k, l));
    for (int j = 0; j < functions_of(map); ++j) {
      float f = powers[(SEGMENT_POINTS - 1) * FUNCTIONS + j];
      for (int k = SEGMENT_POINTS - 2; k >= 0; --k)
        f = fma(f, LANE(pivot->t, l), powers[k * FUNCTIONS + j]);
      LANE(f_k[j], l) = f;
    }
  }
}

// The names of polynomial_sums.cl with a suffix: sum_t_float, sum_t_double.
#define TYPED(name) GLUE(GLUE(name, _), SUM)
#define sum_t TYPED(sum_t)
#define sum_vec TYPED(sum_vec)
#define sums_t TYPED(sums_t)
#define weighted_fit_t TYPED(weighted_fit_t)
#define sum_fma TYPED(sum_fma)
#define sum_madd TYPED(sum_madd)
#define sum_scale TYPED(sum_scale)
#define sum_add TYPED(sum_add)
#define sum_dot TYPED(sum_dot)
#define rounded TYPED(rounded)
#define displacement_at TYPED(displacement_at)
#define add_group TYPED(add_group)
#define add_segment TYPED(add_segment)
#define region_moment TYPED(region_moment)
#define add_region TYPED(add_region)
#define region_influence TYPED(region_influence)
#define add_sums TYPED(add_sums)
#define add_control_points TYPED(add_control_points)
#define add_in_loops TYPED(add_in_loops)
#define values_of TYPED(values_of)
#define values_t TYPED(values_t)
#define sum_up TYPED(sum_up)
#define orthogonalize TYPED(orthogonalize)
#define fit_polynomials TYPED(fit_polynomials)
#define fitted_displacement TYPED(fitted_displacement)
#define coefficients_of TYPED(coefficients_of)
#define influence_of TYPED(influence_of)
#define set_slopes TYPED(set_slopes)
#define fitted_jacobian TYPED(fitted_jacobian)

// Degree 3 is fitted in double only, which most of its points need.
#if defined(USE_FP64) && FUNCTIONS <= 9
#define MIXED 1  // float, and double where it is needed
#else
#define MIXED 0
#endif

#ifdef USE_FP64
#define SUM double
#include "polynomial_sums.cl"
#endif
#if MIXED
#undef SUM
#endif
#ifndef SUM
#define SUM float
#include "polynomial_sums.cl"
#endif

// From here on names without a suffix are those of the last type.
typedef weighted_fit_t fit_t;

// Sums over segments and proxies are longer in code.
#define REFINED (MIXED && !REGIONS && !SEGMENTS)

#if MIXED
#include "digit_loss.cl"
#if REFINED
#include "refinement.cl"
#endif

// The fit at the same point in double.
inline weighted_fit_t_double fitted_in_double(const map_t *map, const fit_t *fit) {
  weighted_fit_t_double exact;
  exact.point = fit->point;
  exact.pivot = fit->pivot;
  fit_polynomials_double(map, &exact);
  return exact;
}
#endif

// Fits the map at fit->point.
inline void fit_step(const map_t *map, fit_t *fit) {
  fit->pivot = find_pivot(map, &fit->point);
#if MIXED
  fit->is_inexact = (real)(0) == 0;
  if (map->params.alpha > MAX_FLOAT_ALPHA) return;
#endif
  fit_polynomials(map, fit);
#if MIXED
  fit->loss = coefficient_loss(map, fit);
  fit->is_inexact = is_inexact_at(map, fit, fit->psi);
#endif
}

// G(v) - v - mean displacement, Eq. 26.
inline vec displacement_of(const map_t *map, const fit_t *fit) {
#if MIXED
  integer is_inexact = fit->is_inexact;
  vec d = {0, 0, 0};  // where all need double
  if (!ALL(is_inexact)) d = fitted_displacement(map, fit);
#if REFINED
  if (ANY(is_inexact) && map->params.alpha <= MAX_FLOAT_ALPHA) {
    const vec refined = refined_displacement(map, fit, &is_inexact);
    d = vec_select(d, refined, fit->is_inexact);
  }
#endif
  if (!ANY(is_inexact)) return d;
  const weighted_fit_t_double exact = fitted_in_double(map, fit);
  return vec_select(d, fitted_displacement_double(map, &exact), is_inexact);
#else
  return fitted_displacement(map, fit);
#endif
}

#if MIXED
// The matrices of b where c is set, else those of a.
inline weight_jacobian_t jacobian_select(weight_jacobian_t a, weight_jacobian_t b, integer c) {
  for (int i = 0; i < 9; ++i) {
    a.d_dv.a[i] = select(a.d_dv.a[i], b.d_dv.a[i], c);
    if (AT_REST) a.d_dx.a[i] = select(a.d_dx.a[i], b.d_dx.a[i], c);
  }
  return a;
}
#endif

#define HAS_TRANSPOSED_JACOBIAN ONLY_CONTROL_POINTS
// Whether transposed_displacement_jacobian() is as exact as displacement_jacobian().
inline int is_transposed_jacobian_exact(const map_t *map, const fit_t *fit) {
#if MIXED
  return !ANY(fit->is_inexact) && !ANY(is_jacobian_inexact(map, fit));
#else
  return 1;
#endif
}

// d(n . (G - v))/dv, as displacement_jacobian() has it.
inline vec transposed_displacement_jacobian(const map_t *map, const fit_t *fit, vec n) {
  const int functions = functions_of(map);
  const sum_vec by = {TO_SUM(n.x), TO_SUM(n.y), TO_SUM(n.z)};
  sum_t t[FUNCTIONS], along[FUNCTIONS];
  sum_vec c[FUNCTIONS];
  influence_of(map, fit, t);
  coefficients_of(map, fit, c);
  UNROLL for (int j = 0; j < functions; ++j) along[j] = sum_dot(by, c[j]);
  const sum_t mean = sum_dot(by, fit->mean);
  gains_t gains = {0, {0, 0, 0}};
  for (int i = 0; i < map->params.count; ++i) {
    pair_t pair;
    set_pair(&pair, control_point_of(map, i), &fit->pivot);
    sum_t influence = fit->share, residual = TO_SUM(dot3(n, pair.u)) - mean;
    UNROLL for (int j = 0; j < functions; ++j) {
      const sum_t f = TO_SUM(values_at(map, i)[j] - fit->f_k[j]) - fit->center[j];
      influence = sum_fma(t[j], f, influence);
      residual = sum_fma(-f, along[j], residual);
    }
    add_gain(&gains, map, i, &fit->pivot, pair.q, SUM_TO_REAL(influence * residual));
  }
  mat slopes;
  set_slopes(map, fit->point.v, c, &slopes);
  return vec_add(transposed_mat_vec(&slopes, n),
                 slope_of_gains(&gains, map, &fit->pivot, &fit->point));
}

// d(G - v)/dv, rows by the component of G.
inline weight_jacobian_t displacement_jacobian(const map_t *map, const fit_t *fit) {
#if MIXED
  integer is_inexact = fit->is_inexact;
  if (!ALL(is_inexact)) is_inexact |= is_jacobian_inexact(map, fit);
  if (ANY(is_inexact)) {
    const weighted_fit_t_double exact = fitted_in_double(map, fit);
    weight_jacobian_t jacobian = fitted_jacobian_double(map, &exact);
    if (ALL(is_inexact)) return jacobian;
    return jacobian_select(fitted_jacobian(map, fit), jacobian, is_inexact);
  }
#endif
  return fitted_jacobian(map, fit);
}
