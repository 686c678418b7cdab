// Whether a fit in float is exact enough.
//
// Rounding changes an entry of the Gram matrix G by about ROUNDING sqrt(G_jj G_ll). The elimination
// magnifies that. With D_j, the square norm of psi_j, a value of the fit is off by about ROUNDING A B:
//   A = sum_j |psi_j(v)| sqrt(G_jj) / D_j,  B = sum_j |<u, psi_j>| sqrt(G_jj) / D_j.
// The true error is mostly 0.3 to 3 times that, and at most 40 times.

#define ROUNDING 6e-8f  // half a unit in the last place of float
// The same in the bound of a refined displacement. Affine maps, whose tolerance is smaller, do not
// reach it, for errors have both signs.
#define REFINED_ROUNDING (FUNCTIONS == 3 ? 2.4e-8f : ROUNDING)
// Tolerated errors by that estimate, local units: of a displacement, relative to the size of v and to
// that of the displacement of k; of a Jacobian.
#define TOLERANCE (FUNCTIONS == 3 ? 1e-7f : 4.5e-6f)
#define DISPLACEMENT_TOLERANCE (FUNCTIONS == 3 ? 2e-7f : 6e-7f)
#define SLOPE_TOLERANCE 2.5e-5f

// With a larger alpha most points need double, and float only adds to the time. The searches for an
// origin and for an inverse do not end before rounding is below their own tolerances.
#ifndef INVERSE
#define INVERSE 0
#endif
#define MAX_FLOAT_ALPHA (FUNCTIONS == 3 ? 4.0f : AT_REST || INVERSE ? 2.0f : 3.0f)

inline real absolute_sum(vec a) { return fabs(a.x) + fabs(a.y) + fabs(a.z); }

// sqrt(G_jj) / D_j.
inline real magnification(const fit_t *fit, int j) {
  return fit->inverse[j] * sqrt(fit->lower[AT(j, j)]);
}

// A, for the FUNCTIONS values `psi`; a pointer, for it may be a member of `fit`: with generic address
// spaces (PoCL 7) an array parameter takes private arrays only.
inline real value_loss(const map_t *map, const fit_t *fit, const real *psi) {
  const int functions = functions_of(map);
  real sum = 0;
  UNROLL for (int j = 0; j < functions; ++j) sum = fma(fabs(psi[j]), magnification(fit, j), sum);
  return sum;
}

// B; infinite if rounding leaves nothing of a function.
inline real coefficient_loss(const map_t *map, const fit_t *fit) {
  const int functions = functions_of(map);
  real sum = 0;
  UNROLL for (int j = 0; j < functions; ++j) {
    integer vanishes = (fit->inverse[j] == 0) & (fit->lower[AT(j, j)] != 0);
    const real loss = magnification(fit, j) * absolute_sum(rounded(fit->c[j]));
    sum += select(loss, (real)(INFINITY), vanishes);
  }
  return sum;
}

inline real displacement_tolerance(const fit_t *fit) {
  const real tolerance = TOLERANCE * size_of(fit->point.v);
  return fma((real)(DISPLACEMENT_TOLERANCE), absolute_sum(fit->pivot.u), tolerance);
}

// Whether a displacement is too inexact, for `psi` at v. Comparisons are written so that NaN is.
inline integer is_inexact_at(const map_t *map, const fit_t *fit, const real *psi) {
  return !(ROUNDING * fit->loss * value_loss(map, fit, psi) <= displacement_tolerance(fit));
}

// From values of the basis functions to those of psi.
inline void eliminate(const map_t *map, const fit_t *fit, real *f) {
  const int functions = functions_of(map);
  UNROLL for (int j = 0; j < functions; ++j)
    UNROLL for (int l = 0; l < j; ++l) f[j] = fma(-fit->lower[AT(j, l)], f[l], f[j]);
}

// Whether the Jacobian is too inexact.
inline integer is_jacobian_inexact(const map_t *map, const fit_t *fit) {
  const int functions = functions_of(map);
  real loss = 0;
  for (int axis = 0; axis < 3; ++axis) {
    real m[MONOMIALS], psi[FUNCTIONS];
    monomial_slopes(fit->point.v, axis, m);
    combine(map->kind_table, functions, m, psi);
    eliminate(map, fit, psi);
    loss = fast_max(loss, value_loss(map, fit, psi));
  }
  return !(ROUNDING * fit->loss * loss <= SLOPE_TOLERANCE);
}
