// The affine and polynomial kinds, Eq. 23 to 26: p - q is fitted by weighted orthogonal polynomials.
//
// The orthogonalisation is done on coefficients: the Gram matrix of the basis functions (relative
// to k and centred, divided by r) is L D L^T, psi = L^-1 f are orthogonal, D their square norms.
// A function whose norm vanishes next to what it was adds nothing.

#include "basis.cl"

#define GRAM_SIZE (FUNCTIONS * (FUNCTIONS + 1) / 2)
#define AT(i, j) ((i) * ((i) + 1) / 2 + (j))  // j <= i
#define VANISHING 1e-6f

// Three functions fit the registers; unrolling more only lengthens the build.
#if FUNCTIONS == 3
#define UNROLL _Pragma("unroll")
#else
#define UNROLL
#endif

typedef struct {
  view_t view;
  pivot_t pivot;
  real share;              // r / W
  vec mean;                // weighted mean of u - u_k
  real f_k[FUNCTIONS];     // basis functions at k
  real centre[FUNCTIONS];  // their weighted mean, less f_k
  real lower[GRAM_SIZE];   // L
  real inverse[FUNCTIONS]; // 1 / D, or 0
  real psi[FUNCTIONS];     // at v
  vec c[FUNCTIONS];        // <u, psi_j>
} fit_t;

typedef struct {
  real weight;
  vec u;
  real f[FUNCTIONS];
  real gram[GRAM_SIZE];
  vec uf[FUNCTIONS];
} sums_t;

inline void clear_sums(sums_t *sums) {
  sums->weight = 0;
  sums->u = (vec){0, 0, 0};
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
    sums->f[j] = 0;
    sums->uf[j] = (vec){0, 0, 0};
  }
  for (int i = 0; i < GRAM_SIZE; ++i) sums->gram[i] = 0;
}

inline void add_handle(sums_t *sums, const map_t *map, int i, const fit_t *fit) {
  const pivot_t *pivot = &fit->pivot;
  __global const float *handle = map->handles + (long)i * HANDLE_SIZE;
  __global const float *values = map->values + (long)i * FUNCTIONS;
  real w = handle_weight(map, i, pivot, &fit->view);
  vec u = {handle[4] - pivot->u.x, handle[5] - pivot->u.y, handle[6] - pivot->u.z};
  sums->weight += w;
  sums->u = vec_madd(w, u, sums->u);
  real f[FUNCTIONS];
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) f[j] = values[j] - fit->f_k[j];
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
    real wf = w * f[j];
    sums->f[j] += wf;
    sums->uf[j] = vec_madd(wf, u, sums->uf[j]);
    UNROLL for (int l = 0; l <= j; ++l) sums->gram[AT(j, l)] = fma(wf, f[l], sums->gram[AT(j, l)]);
  }
}

inline void add_sums(sums_t *total, const sums_t *part) {
  total->weight += part->weight;
  total->u = vec_add(total->u, part->u);
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
    total->f[j] += part->f[j];
    total->uf[j] = vec_add(total->uf[j], part->uf[j]);
  }
  for (int i = 0; i < GRAM_SIZE; ++i) total->gram[i] += part->gram[i];
}

// L D L^T of the Gram matrix in `lower` (D goes to `inverse`), in place.
inline void orthogonalise(fit_t *fit) {
  real *g = fit->lower;
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
    real before = g[AT(j, j)];
    UNROLL for (int l = 0; l < j; ++l) {
      real scaled = g[AT(j, l)];  // L_jl D_l
      for (int m = 0; m < l; ++m) scaled = fma(-g[AT(j, m)], g[AT(l, m)], scaled);
      g[AT(j, l)] = scaled;
    }
    real norm = before;
    UNROLL for (int l = 0; l < j; ++l) {
      real scaled = g[AT(j, l)];
      g[AT(j, l)] = scaled * fit->inverse[l];
      norm = fma(-scaled, g[AT(j, l)], norm);
    }
    integer lost = norm <= VANISHING * before;
    fit->inverse[j] = select(1 / norm, (real)(0), lost);
  }
}

inline fit_t fit_at(const map_t *map, vec v) {
  fit_t fit;
  fit.view = view_at(map, v);
  fit.pivot = find_pivot(map, &fit.view);
  const pivot_t *pivot = &fit.pivot;
  for (int l = 0; l < LANES; ++l) {
    __global const float *nearest = map->values + (long)LANE_INT(pivot->k, l) * FUNCTIONS;
    UNROLL for (int j = 0; j < FUNCTIONS; ++j) LANE(fit.f_k[j], l) = nearest[j];
  }
  sums_t sums;
  clear_sums(&sums);
  int block = block_of(map);
  for (int start = 0; start < map->count; start += block) {
    sums_t part;
    clear_sums(&part);
    int stop = min(start + block, map->count);
    for (int i = start; i < stop; ++i) add_handle(&part, map, i, &fit);
    add_sums(&sums, &part);
  }
  real total = fma(pivot->r, sums.weight - pivot->c, pivot->c);
  fit.share = pivot->r / total;
  fit.mean = vec_scale(fit.share, sums.u);
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
    fit.centre[j] = fit.share * sums.f[j];
    UNROLL for (int l = 0; l <= j; ++l)
      fit.lower[AT(j, l)] = fma(-fit.centre[j], sums.f[l], sums.gram[AT(j, l)]);
  }
  orthogonalise(&fit);
  real m[MONOMIALS], f[FUNCTIONS];
  monomial_differences(pivot->x, v, pivot->q, m);
  combine(map, m, f);
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
    fit.psi[j] = f[j] - fit.centre[j];
    fit.c[j] = vec_madd(-fit.centre[j], sums.u, sums.uf[j]);
    UNROLL for (int l = 0; l < j; ++l) {
      fit.psi[j] = fma(-fit.lower[AT(j, l)], fit.psi[l], fit.psi[j]);
      fit.c[j] = vec_madd(-fit.lower[AT(j, l)], fit.c[l], fit.c[j]);
    }
  }
  return fit;
}

// G(v) - v - drift, Eq. 26.
inline vec displacement_of(const map_t *map, const fit_t *fit) {
  vec sum = fit->mean;
  UNROLL for (int j = 0; j < FUNCTIONS; ++j)
    sum = vec_madd(fit->psi[j] * fit->inverse[j], fit->c[j], sum);
  return vec_add(fit->pivot.u, sum);
}

// d(G - v)/dv, rows by the component of G: the slope of the fitted polynomial, and the influence
// of each control point's residual times the change of its weight (vtk_mls/reference.py).
inline mat displacement_jacobian(const map_t *map, const fit_t *fit) {
  const pivot_t *pivot = &fit->pivot;
  vec near = pivot_slope(map, pivot, &fit->view);
  // back from psi to the basis: coefficients of the fit, and of the influence
  real t[FUNCTIONS];
  vec c[FUNCTIONS];
  UNROLL for (int j = FUNCTIONS - 1; j >= 0; --j) {
    t[j] = fit->inverse[j] * fit->psi[j];
    c[j] = vec_scale(fit->inverse[j], fit->c[j]);
    UNROLL for (int l = j + 1; l < FUNCTIONS; ++l) {
      t[j] = fma(-fit->lower[AT(l, j)], t[l], t[j]);
      c[j] = vec_madd(-fit->lower[AT(l, j)], c[l], c[j]);
    }
  }
  mat jacobian;
  for (int axis = 0; axis < 3; ++axis) {
    real m[MONOMIALS], f[FUNCTIONS];
    monomial_slopes(fit->view.v, axis, m);
    combine(map, m, f);
    vec sum = {0, 0, 0};
    UNROLL for (int j = 0; j < FUNCTIONS; ++j) sum = vec_madd(f[j], c[j], sum);
    jacobian.a[axis] = sum.x;
    jacobian.a[3 + axis] = sum.y;
    jacobian.a[6 + axis] = sum.z;
  }
  for (int i = 0; i < map->count; ++i) {
    __global const float *handle = map->handles + (long)i * HANDLE_SIZE;
    __global const float *values = map->values + (long)i * FUNCTIONS;
    real w = handle_weight(map, i, pivot, &fit->view);
    vec slope = vec_scale(w, vec_sub(weight_slope(map, i, &fit->view), near));
    real influence = fit->share;
    vec residual = {handle[4] - pivot->u.x - fit->mean.x, handle[5] - pivot->u.y - fit->mean.y,
                    handle[6] - pivot->u.z - fit->mean.z};
    UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
      real f = values[j] - fit->f_k[j] - fit->centre[j];
      influence = fma(t[j], f, influence);
      residual = vec_madd(-f, c[j], residual);
    }
    add_outer(&jacobian, residual, vec_scale(influence, slope));
  }
  return jacobian;
}
