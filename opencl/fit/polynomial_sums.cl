// The fit of weighted orthogonal polynomials with sums of the type SUM. fit_polynomial.cl includes this
// file for float and for double: its macros give each name here a suffix for the type.
//
// The orthogonalization is done on coefficients: the Gram matrix of the basis functions (relative
// to k and centered, divided by r) is L D L^T, psi = L^-1 f are orthogonal, D their square norms.
// A function whose norm vanishes relative to its norm before the elimination adds nothing.

#include "sums.cl"

typedef struct { sum_t x, y, z; } sum_vec;

typedef struct {
  evaluation_point_t point;
  pivot_t pivot;
  integer is_inexact;       // whether float is too inexact (digit_loss.cl)
  real loss;                // B of digit_loss.cl
  sum_t share;              // r / W
  sum_vec mean;             // weighted mean of u - u_k
  real f_k[FUNCTIONS];      // basis functions at k
  sum_t center[FUNCTIONS];  // weighted mean of the functions, less f_k
  sum_t lower[GRAM_SIZE];   // L; on its diagonal square norms before the elimination
  sum_t inverse[FUNCTIONS]; // 1 / D, or 0
  real f[FUNCTIONS];        // basis functions at v, less f_k
  sum_t psi[FUNCTIONS];     // at v
  sum_vec c[FUNCTIONS];     // <u, psi_j>
} weighted_fit_t;

typedef struct {
  sum_t weight;
  sum_vec u;
  sum_t f[FUNCTIONS];
  sum_t gram[GRAM_SIZE];
  sum_vec uf[FUNCTIONS];
} sums_t;

// In double without the built-in fma(), which PoCL before version 5 calls wrongly for vectors of 512
// bits (quirks.py). Compilers contract the expression.
inline sum_t sum_fma(sum_t a, sum_t b, sum_t c) {
  return sizeof(SUM) > sizeof(float) ? a * b + c : fma(a, b, c);
}

inline sum_vec sum_madd(sum_t s, sum_vec a, sum_vec b) {
  return (sum_vec){sum_fma(s, a.x, b.x), sum_fma(s, a.y, b.y), sum_fma(s, a.z, b.z)};
}
inline sum_vec sum_scale(sum_t s, sum_vec a) { return (sum_vec){s * a.x, s * a.y, s * a.z}; }
inline sum_vec sum_add(sum_vec a, sum_vec b) { return (sum_vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
inline sum_t sum_dot(sum_vec a, sum_vec b) {
  return sum_fma(a.x, b.x, sum_fma(a.y, b.y, a.z * b.z));
}
inline vec rounded(sum_vec a) {
  return (vec){SUM_TO_REAL(a.x), SUM_TO_REAL(a.y), SUM_TO_REAL(a.z)};
}

// p - q of control point i less that of k.
inline sum_vec displacement_at(const map_t *map, int i, const pivot_t *pivot) {
  __global const control_point_t *at = control_point_of(map, i);
  return (sum_vec){TO_SUM(at->u[0] - pivot->u.x), TO_SUM(at->u[1] - pivot->u.y),
                   TO_SUM(at->u[2] - pivot->u.z)};
}

// Adds up to GROUP control points, from `first` to `stop`: weights, displacements and functions,
// relative to k.
inline void add_group(const map_t *map, sums_t *sums, int first, int stop, const weighted_fit_t *fit) {
  const int functions = functions_of(map);
  sum_t w[GROUP], f[GROUP][FUNCTIONS];
  sum_vec u[GROUP];
  UNROLL_ALL for (int b = 0; b < GROUP; ++b) {
    int i = min(first + b, stop - 1);
    __global const float *values = values_at(map, i);
    w[b] = first + b < stop ? TO_SUM(control_point_weight(map, i, &fit->pivot, &fit->point))
                            : (sum_t)(0);
    u[b] = displacement_at(map, i, &fit->pivot);
    UNROLL for (int j = 0; j < functions; ++j) f[b][j] = TO_SUM(values[j] - fit->f_k[j]);
    sums->weight += w[b];
    sums->u = sum_madd(w[b], u[b], sums->u);
  }
  UNROLL for (int j = 0; j < functions; ++j) {
    sum_t wf[GROUP], sum = sums->f[j];
    sum_vec uf = sums->uf[j];
    UNROLL_ALL for (int b = 0; b < GROUP; ++b) {
      wf[b] = w[b] * f[b][j];
      sum += wf[b];
      uf = sum_madd(wf[b], u[b], uf);
    }
    sums->f[j] = sum;
    sums->uf[j] = uf;
    UNROLL for (int l = 0; l <= j; ++l) {
      sum_t product = sums->gram[AT(j, l)];
      UNROLL_ALL for (int b = 0; b < GROUP; ++b) product = sum_fma(wf[b], f[b][l], product);
      sums->gram[AT(j, l)] = product;
    }
  }
}

// Adds segment i. The functions and p - q along it are sums of the polynomials of t that are
// orthogonal for its weight; so their products are sums over these polynomials. Functions beyond the
// rank add zeros: their number is a constant. `has_pivot` is a constant, too: whether k is on the segment
// in any lane. Both together take a third less time.
HOT void add_segment(const map_t *map, sums_t *sums, int i, const segment_weight_t *weight,
                     const weighted_fit_t *fit, const int has_pivot) {
  const placed_segment_t along = placed_segment(map, i, &fit->pivot, weight);
  const factors_t factors = factors_of(weight->m);
  __global const float *powers = powers_along(map, i);
  const integer is_pivot = fit->pivot.k == i;
  const vec middle =
      SEGMENTS > 2 ? vec_madd(factors.l[SEGMENT_POINTS > 1][0], along.along_u, along.u) : along.u;
  const sum_vec u = {TO_SUM(middle.x), TO_SUM(middle.y), TO_SUM(middle.z)};
  const sum_vec du = {TO_SUM(along.along_u.x), TO_SUM(along.along_u.y), TO_SUM(along.along_u.z)};
  sum_t w[SEGMENT_POINTS], f[SEGMENT_POINTS][FUNCTIONS];
  UNROLL_ALL for (int k = 0; k < SEGMENT_POINTS; ++k) w[k] = TO_SUM(factors.norm[k]);
  sums->weight += w[0];
  sums->u = sum_madd(w[0], u, sums->u);
  UNROLL_SEGMENT for (int j = 0; j < FUNCTIONS; ++j) {
    real c[SEGMENT_POINTS];
    set_powers(c, powers, j, fit->f_k[j], &along, is_pivot, weight->from_nearest, has_pivot);
    sum_t wf[SEGMENT_POINTS];
    UNROLL_ALL for (int k = 0; k < SEGMENT_POINTS; ++k) {
      real sum = c[k];
      if (SEGMENTS > 2)  // else about the mean
        UNROLL_ALL for (int l = k + 1; l < SEGMENT_POINTS; ++l) sum = fma(factors.l[l][k], c[l], sum);
      f[k][j] = TO_SUM(sum);
      wf[k] = w[k] * f[k][j];
    }
    sums->f[j] += wf[0];
    sums->uf[j] = sum_madd(wf[SEGMENT_POINTS > 1], du, sum_madd(wf[0], u, sums->uf[j]));
    UNROLL_SEGMENT for (int l = 0; l <= j; ++l) {
      sum_t product = sums->gram[AT(j, l)];
      UNROLL_ALL for (int k = 0; k < SEGMENT_POINTS; ++k) product = sum_fma(wf[k], f[k][l], product);
      sums->gram[AT(j, l)] = product;
    }
  }
}

// A value of `moments_of_region`.
inline SUM region_moment(__global const float *moments, int j) {
  return sizeof(SUM) == sizeof(float) ? moments[j] : (SUM)(moments[j]) + moments[REGION_SIZE + j];
}

// Adds all proxies of region i.
HOT void add_region(const map_t *map, sums_t *sums, int i, const weighted_fit_t *fit) {
  const int functions = functions_of(map);
  __global const float *values = values_at(map, i), *gram = moments_of_region(map, i) + FUNCTIONS;
  const sum_t w = TO_SUM(control_point_weight(map, i, &fit->pivot, &fit->point));
  const sum_vec u = displacement_at(map, i, &fit->pivot);
  sum_t f[FUNCTIONS];
  UNROLL for (int j = 0; j < functions; ++j) f[j] = TO_SUM(values[j] - fit->f_k[j]);
  sums->weight += w;
  sums->u = sum_madd(w, u, sums->u);
  UNROLL for (int j = 0; j < functions; ++j) {
    __global const float *along = gram + GRAM_SIZE + 3 * j;
    const sum_vec uf = {region_moment(along, 0), region_moment(along, 1), region_moment(along, 2)};
    const sum_t wf = w * f[j];
    sums->f[j] += wf;
    sums->uf[j] = sum_madd(w, uf, sum_madd(wf, u, sums->uf[j]));
    UNROLL for (int l = 0; l <= j; ++l)
      sums->gram[AT(j, l)] = sum_fma(w, (sum_t)(region_moment(gram, AT(j, l))),
                                 sum_fma(wf, f[l], sums->gram[AT(j, l)]));
  }
}

// Influence times residual of the proxies of region i, beyond that at their mean.
inline sum_vec region_influence(const map_t *map, int i, const sum_t t[FUNCTIONS],
                                const sum_vec c[FUNCTIONS]) {
  const int functions = functions_of(map);
  __global const float *gram = moments_of_region(map, i) + FUNCTIONS;
  sum_vec sum = {0, 0, 0};
  UNROLL for (int j = 0; j < functions; ++j) {
    __global const float *along = gram + GRAM_SIZE + 3 * j;
    sum_vec residual = {region_moment(along, 0), region_moment(along, 1), region_moment(along, 2)};
    UNROLL for (int l = 0; l < functions; ++l)
      residual = sum_madd(-(sum_t)(region_moment(gram, j < l ? AT(l, j) : AT(j, l))), c[l], residual);
    sum = sum_madd(t[j], residual, sum);
  }
  return sum;
}

inline void add_sums(const map_t *map, sums_t *total, const sums_t *part) {
  const int functions = functions_of(map);
  total->weight += part->weight;
  total->u = sum_add(total->u, part->u);
  UNROLL for (int j = 0; j < functions; ++j) {
    total->f[j] += part->f[j];
    total->uf[j] = sum_add(total->uf[j], part->uf[j]);
  }
  UNROLL for (int i = 0; i < AT(functions, 0); ++i) total->gram[i] += part->gram[i];
}

#if FUNCTIONS == 3
// A control point: its displacement and functions, relative to k.
typedef struct {
  sum_vec u;
  sum_t f[FUNCTIONS];
} values_t;

HOT values_t values_of(const map_t *map, int i, const weighted_fit_t *fit) {
  __global const float *f = values_at(map, i);
  values_t values;
  values.u = displacement_at(map, i, &fit->pivot);
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) values.f[j] = TO_SUM(f[j] - fit->f_k[j]);
  return values;
}

// Adds up to TERM_GROUP control points.
HOT void add_in_loops(const map_t *map, sums_t *sums, int first, int count, const weighted_fit_t *fit) {
  real weights[TERM_GROUP];
  set_weights(weights, map, first, count, &fit->pivot, &fit->point);
  sums_t part = {0};
  for (int b = 0; b < count; ++b) {
    const values_t values = values_of(map, first + b, fit);
    const sum_t w =
        TO_SUM(weight_in_group(weights, map, first, b, &fit->pivot, &fit->point));
    part.weight += w;
    part.u = sum_madd(w, values.u, part.u);
    UNROLL for (int j = 0; j < FUNCTIONS; ++j) part.f[j] = sum_fma(w, values.f[j], part.f[j]);
#if HAS_FEW_REGISTERS
  }
  for (int b = 0; b < count; ++b) {
    const values_t values = values_of(map, first + b, fit);
    const sum_t w = TO_SUM(weights[b]);
#endif
    UNROLL for (int j = 0; j < FUNCTIONS; ++j)
      UNROLL for (int l = 0; l <= j; ++l)
        part.gram[AT(j, l)] = sum_fma(w * values.f[j], values.f[l], part.gram[AT(j, l)]);
#if HAS_FEW_REGISTERS
  }
  for (int b = 0; b < count; ++b) {
    const values_t values = values_of(map, first + b, fit);
    const sum_t w = TO_SUM(weights[b]);
#endif
    UNROLL for (int j = 0; j < FUNCTIONS; ++j)
      part.uf[j] = sum_madd(w * values.f[j], values.u, part.uf[j]);
  }
  add_sums(map, sums, &part);
}
#endif

inline void add_control_points(const map_t *map, sums_t *sums, int first, int stop,
                               const weighted_fit_t *fit) {
#if FUNCTIONS == 3
  if (sizeof(SUM) == sizeof(float)) {
    for (; first < stop; first += TERM_GROUP)
      add_in_loops(map, sums, first, min(stop - first, TERM_GROUP), fit);
    return;
  }
#endif
  for (; first < stop; first += GROUP) add_group(map, sums, first, stop, fit);
}

// Adds all terms.
inline void sum_up(const map_t *map, const weighted_fit_t *fit, sums_t *sums) {
  // sums in double need no blocks
  int block = sizeof(SUM) > sizeof(float) ? map->params.count : block_of(map), first = 0;
  for (; is_region(map, first); ++first) add_region(map, sums, first, fit);
  for (int start = first; start < map->params.count; start += block) {
    sums_t part = {0};
    add_control_points(map, &part, start, min(start + block, map->params.count), fit);
    add_sums(map, sums, &part);
  }
  if (!SEGMENTS) return;
  sums_t along = {0};
  for (int start = map->params.count; start < term_count(map); start += SEGMENT_GROUP) {
    segment_weight_t weights[SEGMENT_GROUP];
    const int count = min(term_count(map) - start, SEGMENT_GROUP);
    for (int j = 0; j < count; ++j)
      weights[j] = segment_weight(map, start + j, &fit->pivot, &fit->point, 0, TOP);
    for (int j = 0; j < count; ++j) {
      if (ANY(fit->pivot.k == start + j))
        add_segment(map, &along, start + j, weights + j, fit, 1);
      else
        add_segment(map, &along, start + j, weights + j, fit, 0);
    }
  }
  add_sums(map, sums, &along);
}

// L D L^T of the centered Gram matrix.
inline void orthogonalize(const map_t *map, weighted_fit_t *fit, const sums_t *sums) {
  const int functions = functions_of(map);
  UNROLL for (int j = 0; j < functions; ++j) {
    fit->center[j] = fit->share * sums->f[j];
    UNROLL for (int l = 0; l <= j; ++l)
      fit->lower[AT(j, l)] = sum_fma(-fit->center[j], sums->f[l], sums->gram[AT(j, l)]);
  }
  sum_t *g = fit->lower;
  UNROLL for (int j = 0; j < functions; ++j) {
    sum_t before = g[AT(j, j)];
    UNROLL for (int l = 0; l < j; ++l) {
      sum_t scaled = g[AT(j, l)];  // L_jl D_l
      for (int m = 0; m < l; ++m) scaled = sum_fma(-g[AT(j, m)], g[AT(l, m)], scaled);
      g[AT(j, l)] = scaled;
    }
    sum_t norm = before;
    UNROLL for (int l = 0; l < j; ++l) {
      sum_t scaled = g[AT(j, l)];
      g[AT(j, l)] = scaled * fit->inverse[l];
      norm = sum_fma(-scaled, g[AT(j, l)], norm);
    }
    fit->inverse[j] = norm <= VANISHING * before ? (sum_t)(0) : 1 / norm;
  }
}

// Fits the map at fit->point, relative to fit->pivot.
inline void fit_polynomials(const map_t *map, weighted_fit_t *fit) {
  const int functions = functions_of(map);
  const pivot_t *pivot = &fit->pivot;
  for (int l = 0; l < LANES; ++l) {
    __global const float *nearest = values_at_pivot(map, LANE_INT(pivot->k, l));
    UNROLL for (int j = 0; j < FUNCTIONS; ++j) LANE(fit->f_k[j], l) = nearest[j];
  }
  if (SEGMENTS && ANY(pivot->k >= map->params.count)) functions_on_segments(map, pivot, fit->f_k);
  sums_t sums = {0};
  sum_up(map, fit, &sums);
  sum_t r = TO_SUM(pivot->r), c = TO_SUM(pivot->c);
  fit->share = r / sum_fma(r, sums.weight - c, c);
  fit->mean = sum_scale(fit->share, sums.u);
  orthogonalize(map, fit, &sums);
  real m[MONOMIALS];
  monomial_differences(pivot->x, fit->point.v, pivot->q, m);
  combine(map->kind_table, functions, m, fit->f);
  UNROLL for (int j = 0; j < functions; ++j) {
    fit->psi[j] = TO_SUM(fit->f[j]) - fit->center[j];
    fit->c[j] = sum_madd(-fit->center[j], sums.u, sums.uf[j]);
    UNROLL for (int l = 0; l < j; ++l) {
      fit->psi[j] = sum_fma(-fit->lower[AT(j, l)], fit->psi[l], fit->psi[j]);
      fit->c[j] = sum_madd(-fit->lower[AT(j, l)], fit->c[l], fit->c[j]);
    }
  }
}

// G(v) - v - mean displacement, Eq. 26.
inline vec fitted_displacement(const map_t *map, const weighted_fit_t *fit) {
  const int functions = functions_of(map);
  sum_vec sum = fit->mean;
  UNROLL for (int j = 0; j < functions; ++j)
    sum = sum_madd(fit->psi[j] * fit->inverse[j], fit->c[j], sum);
  return vec_add(fit->pivot.u, rounded(sum));
}

// The coefficients of the fit in the basis functions.
inline void coefficients_of(const map_t *map, const weighted_fit_t *fit, sum_vec c[FUNCTIONS]) {
  const int functions = functions_of(map);
  UNROLL for (int j = functions - 1; j >= 0; --j) {
    c[j] = sum_scale(fit->inverse[j], fit->c[j]);
    UNROLL for (int l = j + 1; l < functions; ++l)
      c[j] = sum_madd(-fit->lower[AT(l, j)], c[l], c[j]);
  }
}

// The t for which w_i (share + t (f_i - center)) is the share of u_i in the fit.
inline void influence_of(const map_t *map, const weighted_fit_t *fit, sum_t t[FUNCTIONS]) {
  const int functions = functions_of(map);
  UNROLL for (int j = functions - 1; j >= 0; --j) {
    t[j] = fit->inverse[j] * fit->psi[j];
    UNROLL for (int l = j + 1; l < functions; ++l)
      t[j] = sum_fma(-fit->lower[AT(l, j)], t[l], t[j]);
  }
}

// The Jacobian at v of the polynomial with the coefficients c.
inline void set_slopes(const map_t *map, vec v, const sum_vec c[FUNCTIONS], mat *j) {
  const int functions = functions_of(map);
  for (int axis = 0; axis < 3; ++axis) {
    real m[MONOMIALS], f[FUNCTIONS];
    monomial_slopes(v, axis, m);
    combine(map->kind_table, functions, m, f);
    sum_vec sum = {0, 0, 0};
    UNROLL for (int i = 0; i < functions; ++i) sum = sum_madd(TO_SUM(f[i]), c[i], sum);
    set_mat_column(j, axis, rounded(sum));
  }
}

// d(G - v)/dv, rows by the component of G: the slope of the fitted polynomial, and the influence
// of each control point's residual times the change of its weight
// (vtk_mls/reference/reference_engine.py).
inline weight_jacobian_t fitted_jacobian(const map_t *map, const weighted_fit_t *fit) {
  const int functions = functions_of(map);
  const pivot_t *pivot = &fit->pivot;
  weight_jacobian_t jacobian = no_weight_jacobian(map, pivot, &fit->point);
  sum_t t[FUNCTIONS];
  sum_vec c[FUNCTIONS];
  influence_of(map, fit, t);
  coefficients_of(map, fit, c);
  set_slopes(map, fit->point.v, c, &jacobian.d_dv);
  for (int i = 0; i < term_count(map); ++i) {
    change_t changes[CHANGES];
    const int count = is_region(map, i)
                          ? change_of(map, i, pivot, &fit->point, &jacobian, changes)
                          : changes_of(map, i, pivot, &fit->point, &jacobian, changes);
    for (int b = 0; b < count; ++b) {
      const vec u = changes[b].u;
      real values[FUNCTIONS];
      if (is_segment(map, i))
        functions_along(map, pivot, changes[b].q, values);
      else
        UNROLL for (int j = 0; j < functions; ++j) values[j] = values_at(map, i)[j] - fit->f_k[j];
      sum_t influence = fit->share;
      sum_vec residual = sum_madd((sum_t)(-1), fit->mean,
                                  (sum_vec){TO_SUM(u.x), TO_SUM(u.y), TO_SUM(u.z)});
      UNROLL for (int j = 0; j < functions; ++j) {
        sum_t f = TO_SUM(values[j]) - fit->center[j];
        influence = sum_fma(t[j], f, influence);
        residual = sum_madd(-f, c[j], residual);
      }
      residual = sum_scale(influence, residual);
      if (is_region(map, i)) residual = sum_add(residual, region_influence(map, i, t, c));
      add_influence(&jacobian, changes + b, rounded(residual));
    }
  }
  return jacobian;
}
