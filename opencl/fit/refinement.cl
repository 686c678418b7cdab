// One step of iterative refinement of a fit in float, as a rule instead of a fit in double.
//
// With coefficients x of the basis functions f relative to k, the fit at v is m + f(v) x with
// m = mean - center x. Rounding changes x, mostly by the elimination. The residuals u_i - m - f_i x
// are small where weights are large. So the sum of w f (u - m - f x) is exact enough in float, and the
// factors of G give the change of x. What rounding still changes is about ROUNDING sum_j G_jj / D_j
// times that change, and the rounding of the residuals.

// What the next step may change, relative to the tolerance, by ten times that estimate. And the
// rounding of the residuals, relative to the tolerance; its estimate is 10 to 100 times too large.
#define MAX_CHANGE 0.25f
#define MAX_RESIDUAL_LOSS 3

// Adds w f (u - m - f x) of up to GROUP control points, from `first` to `stop`.
HOT void add_residuals(const map_t *map, sum_vec sums[FUNCTIONS], int first, int stop,
                       const fit_t *fit, sum_vec m, const sum_vec x[FUNCTIONS]) {
  const int functions = functions_of(map);
  real f[GROUP][FUNCTIONS];
  sum_vec residual[GROUP];
  UNROLL_GROUP for (int b = 0; b < GROUP; ++b) {
    const int i = min(first + b, stop - 1);
    __global const float *values = values_at(map, i);
    residual[b] = sum_madd((real)(-1), m, displacement_at(map, i, &fit->pivot));
    for (int j = 0; j < functions; ++j) {
      f[b][j] = values[j] - fit->f_k[j];
      residual[b] = sum_madd(-f[b][j], x[j], residual[b]);
    }
    const real w = control_point_weight(map, i, &fit->pivot, &fit->point);
    residual[b] = sum_scale(first + b < stop ? w : (real)(0), residual[b]);
  }
  for (int j = 0; j < functions; ++j) {
    sum_vec sum = sums[j];
    UNROLL_GROUP for (int b = 0; b < GROUP; ++b) sum = sum_madd(f[b][j], residual[b], sum);
    sums[j] = sum;
  }
}

// The same of all control points, in blocks.
inline void sum_residuals(const map_t *map, sum_vec sums[FUNCTIONS], const fit_t *fit, sum_vec m,
                          const sum_vec x[FUNCTIONS]) {
  const int functions = functions_of(map), block = block_of(map);
  for (int j = 0; j < functions; ++j) sums[j] = (sum_vec){0, 0, 0};
  for (int start = 0; start < map->params.count; start += block) {
    const int stop = min(start + block, map->params.count);
    sum_vec part[FUNCTIONS];
    for (int j = 0; j < functions; ++j) part[j] = (sum_vec){0, 0, 0};
    for (int first = start; first < stop; first += GROUP)
      add_residuals(map, part, first, stop, fit, m, x);
    for (int j = 0; j < functions; ++j) sums[j] = sum_add(sums[j], part[j]);
  }
}

// The refined displacement; clears `is_inexact` where it is exact enough.
inline vec refined_displacement(const map_t *map, const fit_t *fit, integer *is_inexact) {
  const int functions = functions_of(map);
  sum_vec x[FUNCTIONS], change[FUNCTIONS], m = fit->mean;
  coefficients_of(map, fit, x);
  real monomials[MONOMIALS], f[FUNCTIONS];
  monomial_differences(fit->pivot.x, fit->point.v, fit->pivot.q, monomials);
  combine(map->kind_table, functions, monomials, f);
  real loss = 0, ratio = 0;
  integer vanishes = (real)(0) != 0;
  for (int j = 0; j < functions; ++j) {
    m = sum_madd(-fit->center[j], x[j], m);
    loss = fma(sqrt(fit->lower[AT(j, j)]), absolute_sum(rounded(x[j])), loss);
    ratio = fma(fit->inverse[j], fit->lower[AT(j, j)], ratio);
    vanishes |= (fit->inverse[j] == 0) & (fit->lower[AT(j, j)] != 0);
  }
  sum_residuals(map, change, fit, m, x);
  sum_vec value = m, added = {0, 0, 0};
  for (int j = 0; j < functions; ++j) {
    for (int l = 0; l < j; ++l)
      change[j] = sum_madd(-fit->lower[AT(j, l)], change[l], change[j]);
    value = sum_madd(f[j], x[j], value);
    added = sum_madd(fit->psi[j] * fit->inverse[j], change[j], added);
  }
  const real tolerance = displacement_tolerance(fit);
  loss *= ROUNDING * value_loss(map, fit, fit->psi);
  const real next = 10 * ROUNDING * ratio * absolute_sum(rounded(added));
  *is_inexact &= vanishes | !((loss <= MAX_RESIDUAL_LOSS * tolerance) &
                              (next <= MAX_CHANGE * tolerance));
  return vec_add(fit->pivot.u, rounded(sum_add(value, added)));
}
