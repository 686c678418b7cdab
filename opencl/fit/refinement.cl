// One step of refinement of a fit in float, as a rule instead of a fit in double.
//
// The fit at v is sum_i lambda_i u_i with lambda_i = w_i (r / W + t (f_i - center)), where G t =
// f(v) - center, all relative to k. Rounding changes t, mostly by the elimination, so that f is
// reproduced but for r = sum_i lambda_i f_i - f(v). With the coefficients x of the fit, u_i is f_i x
// and a residual, which lambda_i of any t do not add. So sum_i lambda_i u_i - r x is off by r times
// the error of x, and by rounding.

// Sums of lambda_i, which are exact enough in float.
typedef struct {
  real size;  // sum |lambda_i|
  sum_vec u;
  real f[FUNCTIONS];
} share_sums_t;

// Adds up to GROUP control points, from `first` to `stop`. `shift` is r / W - t center.
HOT void add_shares(const map_t *map, share_sums_t *sums, int first, int stop, const fit_t *fit,
                    real shift, const real t[FUNCTIONS]) {
  const int functions = functions_of(map);
  real f[GROUP][FUNCTIONS], lambda[GROUP];
  UNROLL_GROUP for (int b = 0; b < GROUP; ++b) {
    const int i = min(first + b, stop - 1);
    __global const float *values = values_at(map, i);
    lambda[b] = shift;
    UNROLL for (int j = 0; j < functions; ++j) {
      f[b][j] = values[j] - fit->f_k[j];
      lambda[b] = fma(t[j], f[b][j], lambda[b]);
    }
    const real w = control_point_weight(map, i, &fit->pivot, &fit->point);
    lambda[b] = first + b < stop ? w * lambda[b] : (real)(0);
    sums->size += fabs(lambda[b]);
    sums->u = sum_madd(lambda[b], displacement_at(map, i, &fit->pivot), sums->u);
  }
  UNROLL for (int j = 0; j < functions; ++j) {
    real sum = sums->f[j];
    UNROLL_GROUP for (int b = 0; b < GROUP; ++b) sum = fma(lambda[b], f[b][j], sum);
    sums->f[j] = sum;
  }
}

// The sums over all control points, in blocks.
inline void sum_shares(const map_t *map, share_sums_t *sums, const fit_t *fit, real shift,
                       const real t[FUNCTIONS]) {
  const int functions = functions_of(map), block = block_of(map);
  *sums = (share_sums_t){0};
  for (int start = 0; start < map->params.count; start += block) {
    const int stop = min(start + block, map->params.count);
    share_sums_t part = {0};
    for (int first = start; first < stop; first += GROUP)
      add_shares(map, &part, first, stop, fit, shift, t);
    sums->size += part.size;
    sums->u = sum_add(sums->u, part.u);
    UNROLL for (int j = 0; j < functions; ++j) sums->f[j] += part.f[j];
  }
}

// The refined displacement; clears `is_inexact` where it is exact enough.
inline vec refined_displacement(const map_t *map, const fit_t *fit, integer *is_inexact) {
  const int functions = functions_of(map);
  real t[FUNCTIONS], shift = fit->share, size = 0;
  sum_vec x[FUNCTIONS];
  influence_of(map, fit, t);
  coefficients_of(map, fit, x);
  UNROLL for (int j = 0; j < functions; ++j) shift = fma(-t[j], fit->center[j], shift);
  share_sums_t sums;
  sum_shares(map, &sums, fit, shift, t);
  UNROLL for (int j = 0; j < functions; ++j) {
    sums.f[j] -= fit->f[j];
    sums.u = sum_madd(-sums.f[j], x[j], sums.u);
    size += absolute_sum(rounded(x[j]));
  }
  eliminate(map, fit, sums.f);
  const real rounding = ROUNDING * sums.size * size;
  *is_inexact &= is_inexact_at(map, fit, sums.f) | !(rounding <= displacement_tolerance(fit));
  return vec_add(fit->pivot.u, rounded(sums.u));
}
