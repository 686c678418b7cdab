// One step of refinement of a fit in float, as a rule instead of a fit in double.
//
// The fit at v is sum_i lambda_i u_i with lambda_i = w_i (r / W + t (f_i - center)), where G t =
// f(v) - center, all relative to k. Rounding changes t, mostly by the elimination, so that f is
// reproduced but for r = sum_i lambda_i f_i - f(v). With the coefficients x of the fit, u_i is f_i x
// and a residual, whose sum with lambda_i is 0 for any t. So sum_i lambda_i u_i - r x is off by r times
// the error of x, and by rounding.

// Sums of lambda_i and of what they are shares of. So r is that of lambda_i as rounded.
typedef struct {
  real size;  // sum |lambda_i|
  real one;
  vec u;
  real f[FUNCTIONS];
} share_sums_t;

// Adds control point i; lambda_i is w_i (t f_i + shift). All loops are over constants, for the sums fit
// the registers.
HOT void add_share(const map_t *map, share_sums_t *sums, int i, const fit_t *fit, real shift,
                   const real t[FUNCTIONS]) {
  __global const float *values = values_at(map, i);
  real lambda = shift;
  UNROLL_ALL for (int j = 0; j < FUNCTIONS; ++j) lambda = fma(t[j], (real)(values[j]), lambda);
  lambda *= control_point_weight(map, i, &fit->pivot, &fit->point);
  sums->size += fabs(lambda);
  sums->one += lambda;
  sums->u = vec_madd(lambda, load3(control_point_of(map, i)->u), sums->u);
  UNROLL_ALL for (int j = 0; j < FUNCTIONS; ++j)
    sums->f[j] = fma(lambda, (real)(values[j]), sums->f[j]);
}

// The sums over all control points, in blocks.
inline void sum_shares(const map_t *map, share_sums_t *sums, const fit_t *fit, real shift,
                       const real t[FUNCTIONS]) {
  const int block = block_of(map);
  *sums = (share_sums_t){0};
  for (int start = 0; start < map->params.count; start += block) {
    const int stop = min(start + block, map->params.count);
    share_sums_t part = {0};
    for (int i = start; i < stop; ++i) add_share(map, &part, i, fit, shift, t);
    sums->size += part.size;
    sums->one += part.one;
    sums->u = vec_add(sums->u, part.u);
    UNROLL_ALL for (int j = 0; j < FUNCTIONS; ++j) sums->f[j] += part.f[j];
  }
}

// The refined displacement; clears `is_inexact` where it is exact enough.
inline vec refined_displacement(const map_t *map, const fit_t *fit, integer *is_inexact) {
  const int functions = functions_of(map);
  real t[FUNCTIONS] = {0}, shift = fit->share, size = 0;
  sum_vec x[FUNCTIONS];
  influence_of(map, fit, t);
  coefficients_of(map, fit, x);
  UNROLL for (int j = 0; j < functions; ++j) shift = fma(-t[j], fit->center[j] + fit->f_k[j], shift);
  share_sums_t sums;
  sum_shares(map, &sums, fit, shift, t);
  vec value = vec_madd(-sums.one, fit->pivot.u, vec_add(sums.u, fit->pivot.u));
  UNROLL for (int j = 0; j < functions; ++j) {
    sums.f[j] = fma(-sums.one, fit->f_k[j], sums.f[j] - fit->f[j]);
    value = vec_madd(-sums.f[j], rounded(x[j]), value);
    size += absolute_sum(rounded(x[j]));
  }
  eliminate(map, fit, sums.f);
  const real rounding = REFINED_ROUNDING * sums.size * size;
  *is_inexact &= is_inexact_at(map, fit, sums.f) | !(rounding <= displacement_tolerance(fit));
  return value;
}
