// The affine and polynomial kinds, Eq. 23 to 26: p - q is fitted by weighted orthogonal polynomials.
//
// The orthogonalisation is done on coefficients: the Gram matrix of the basis functions (relative
// to k and centred, divided by r) is L D L^T, psi = L^-1 f are orthogonal, D their square norms.
// A function whose norm vanishes next to what it was adds nothing.
//
// The digits of that elimination are lost where a few control points outweigh all others by far (an
// isolated pair, say). There the sums are taken again in a basis that Householder reflections have
// turned: the control point that weighs most differs from k in the first function alone, the next
// in the first two, and so on, so that they do not mix with what the others say of the rest.

#include "basis.cl"

#define GRAM_SIZE (FUNCTIONS * (FUNCTIONS + 1) / 2)
#define AT(i, j) ((i) * ((i) + 1) / 2 + (j))  // j <= i
#define VANISHING 1e-6f
#define DOUBTFUL 0.1f  // of its square norm left: a digit is lost, and over many functions more
#define REFLECTIONS (FUNCTIONS > 3 ? 6 : 2)  // at most, two at a time
#define FLAT_WEIGHTS (TWICE_ALPHA == 1 || TWICE_ALPHA == 2)  // no digits are lost

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
  integer doubtful;        // lanes whose digits the elimination in the given basis loses
  int reflections;         // of the basis, in those lanes
  real mirror[REFLECTIONS][FUNCTIONS];  // their normals, length sqrt(2), or 0
  real centre[FUNCTIONS];  // weighted mean of the functions, less f_k
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

inline real square_from(const real f[FUNCTIONS], int first) {
  real square = 0;
  UNROLL for (int j = first; j < FUNCTIONS; ++j) square = fma(f[j], f[j], square);
  return square;
}

inline void reflect(const fit_t *fit, int s, real f[FUNCTIONS]) {
  const real *mirror = fit->mirror[s];
  real along = 0;
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) along = fma(mirror[j], f[j], along);
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) f[j] = fma(-along, mirror[j], f[j]);
}

// Differences or slopes of basis functions, in the turned basis.
inline void turn(const fit_t *fit, real f[FUNCTIONS]) {
  UNROLL for (int s = 0; s < REFLECTIONS; ++s)
    if (s < fit->reflections) reflect(fit, s, f);
}

// Differences at a control point, after the first `reflections`: what is rounding becomes 0.
inline void turn_handle(const fit_t *fit, const int reflections, real f[FUNCTIONS]) {
  real rounding = select((real)(0), 1e-12f * square_from(f, 0), fit->doubtful);
  UNROLL for (int s = 0; s < REFLECTIONS; ++s)
    if (s < reflections) {
      reflect(fit, s, f);
      integer vanishes = (square_from(f, s + 1) < rounding) & (fit->mirror[s][s] != 0);
      UNROLL for (int j = s + 1; j < FUNCTIONS; ++j) f[j] = select(f[j], (real)(0), vanishes);
    }
}

// Basis functions at control point i less those at k, after the first `reflections`.
inline void handle_functions(const map_t *map, int i, const fit_t *fit, const int reflections,
                             real f[FUNCTIONS]) {
  __global const float *values = map->values + (long)i * FUNCTIONS;
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) f[j] = values[j] - fit->f_k[j];
#if !FLAT_WEIGHTS
  if (reflections > 0) turn_handle(fit, reflections, f);
#endif
}

inline void add_handle(sums_t *sums, const map_t *map, int i, const fit_t *fit,
                       const int reflections) {
  const pivot_t *pivot = &fit->pivot;
  __global const float *handle = map->handles + (long)i * HANDLE_SIZE;
  real w = handle_weight(map, i, pivot, &fit->view);
  vec u = {handle[4] - pivot->u.x, handle[5] - pivot->u.y, handle[6] - pivot->u.z};
  sums->weight += w;
  sums->u = vec_madd(w, u, sums->u);
  real f[FUNCTIONS];
  handle_functions(map, i, fit, reflections, f);
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

inline void sum_up(const map_t *map, const fit_t *fit, const int reflections, sums_t *sums) {
  clear_sums(sums);
  int block = block_of(map);
  for (int start = 0; start < map->count; start += block) {
    sums_t part;
    clear_sums(&part);
    int stop = min(start + block, map->count);
    for (int i = start; i < stop; ++i) add_handle(&part, map, i, fit, reflections);
    add_sums(sums, &part);
  }
}

// L D L^T of the centred Gram matrix; lanes in which digits were lost.
inline integer orthogonalise(fit_t *fit, const sums_t *sums) {
  UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
    fit->centre[j] = fit->share * sums->f[j];
    UNROLL for (int l = 0; l <= j; ++l)
      fit->lower[AT(j, l)] = fma(-fit->centre[j], sums->f[l], sums->gram[AT(j, l)]);
  }
  real *g = fit->lower;
  integer doubtful = 0;
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
    doubtful |= norm < DOUBTFUL * before;
  }
  return doubtful;
}

// Two more reflections of the basis, each for the control point with the largest weighted part in
// the functions that those before it have left.
inline void find_reflections(const map_t *map, fit_t *fit, const int first, integer doubtful) {
  UNROLL for (int s = first; s < first + 2; ++s) {
    real most_square = 0, mirror[FUNCTIONS] = {0};
    for (int i = 0; i < map->count; ++i) {
      real f[FUNCTIONS];
      handle_functions(map, i, fit, s, f);
      real square = square_from(f, s) * handle_weight(map, i, &fit->pivot, &fit->view);
      integer more = square > most_square;
      most_square = most(most_square, square);
      UNROLL for (int j = s; j < FUNCTIONS; ++j) mirror[j] = select(mirror[j], f[j], more);
    }
    // f - +-|f| e_s, the sign such that nothing cancels
    mirror[s] += copysign(sqrt(square_from(mirror, s)), mirror[s]);
    real square = square_from(mirror, s);
    real scale = select((real)(0), sqrt(2 / square), doubtful & (square >= 1e-30f));
    UNROLL for (int j = 0; j < FUNCTIONS; ++j) fit->mirror[s][j] = scale * mirror[j];
  }
  fit->reflections = first + 2;
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
  sum_up(map, &fit, 0, &sums);
  real total = fma(pivot->r, sums.weight - pivot->c, pivot->c);
  fit.share = pivot->r / total;
  fit.mean = vec_scale(fit.share, sums.u);
  fit.doubtful = orthogonalise(&fit, &sums);
  fit.reflections = 0;
  integer doubtful = fit.doubtful;
  UNROLL for (int first = 0; first < REFLECTIONS; first += 2)
    if (!FLAT_WEIGHTS && ANY(doubtful)) {
      find_reflections(map, &fit, first, doubtful);
      sum_up(map, &fit, first + 2, &sums);
      doubtful &= orthogonalise(&fit, &sums);
    }
  real m[MONOMIALS], f[FUNCTIONS];
  monomial_differences(pivot->x, v, pivot->q, m);
  combine(map, m, f);
  turn(&fit, f);
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
    turn(fit, f);
    vec sum = {0, 0, 0};
    UNROLL for (int j = 0; j < FUNCTIONS; ++j) sum = vec_madd(f[j], c[j], sum);
    jacobian.a[axis] = sum.x;
    jacobian.a[3 + axis] = sum.y;
    jacobian.a[6 + axis] = sum.z;
  }
  for (int i = 0; i < map->count; ++i) {
    __global const float *handle = map->handles + (long)i * HANDLE_SIZE;
    real f[FUNCTIONS];
    handle_functions(map, i, fit, fit->reflections, f);
    real w = handle_weight(map, i, pivot, &fit->view);
    vec slope = vec_scale(w, vec_sub(weight_slope(map, i, &fit->view), near));
    real influence = fit->share;
    vec residual = {handle[4] - pivot->u.x - fit->mean.x, handle[5] - pivot->u.y - fit->mean.y,
                    handle[6] - pivot->u.z - fit->mean.z};
    UNROLL for (int j = 0; j < FUNCTIONS; ++j) {
      f[j] -= fit->centre[j];
      influence = fma(t[j], f[j], influence);
      residual = vec_madd(-f[j], c[j], residual);
    }
    add_outer(&jacobian, residual, vec_scale(influence, slope));
  }
  return jacobian;
}
