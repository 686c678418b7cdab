// The rigid and similarity kinds, Eq. 8 to 22: p = mu R (q - q*) + p*.

#include "rotation.cl"

typedef struct {
  view_t view;
  pivot_t pivot;
  real share;       // r / W: weight of the sums next to the total weight
  vec u;            // p* - q*, less drift
  vec q;            // q* - q_k
  vec s;            // v - q*
  mat c;            // C of Eq. 11, divided by r
  quaternion_t rotation;
  real factor;      // mu - 1
  real spread;      // sum of w |q - q*|^2, divided by r
} fit_t;

typedef struct {
  real weight;
  vec q, u;
  mat c;
#if SIMILARITY
  real spread;
#endif
} sums_t;

inline void add_handle(sums_t *sums, const map_t *map, int i, const pivot_t *pivot,
                       const view_t *view) {
  __global const float *handle = map->handles + (long)i * HANDLE_SIZE;
  real w = handle_weight(map, i, pivot, view);
  vec q = {handle[0] - pivot->q.x, handle[1] - pivot->q.y, handle[2] - pivot->q.z};
  vec u = {handle[4] - pivot->u.x, handle[5] - pivot->u.y, handle[6] - pivot->u.z};
  vec wq = vec_scale(w, q);
  sums->weight += w;
  sums->q = vec_add(sums->q, wq);
  sums->u = vec_madd(w, u, sums->u);
  add_outer(&sums->c, vec_add(q, u), wq);
#if SIMILARITY
  sums->spread = fma(wq.x, q.x, fma(wq.y, q.y, fma(wq.z, q.z, sums->spread)));
#endif
}

inline void add_sums(sums_t *total, const sums_t *part) {
  total->weight += part->weight;
  total->q = vec_add(total->q, part->q);
  total->u = vec_add(total->u, part->u);
  for (int i = 0; i < 9; ++i) total->c.a[i] += part->c.a[i];
#if SIMILARITY
  total->spread += part->spread;
#endif
}

inline fit_t fit_at(const map_t *map, vec v) {
  fit_t fit;
  fit.view = view_at(map, v);
  fit.pivot = find_pivot(map, &fit.view);
  const pivot_t *pivot = &fit.pivot;
  sums_t sums = {0};
  int block = block_of(map);
  for (int start = 0; start < map->count; start += block) {
    sums_t part = {0};
    int stop = min(start + block, map->count);
    for (int i = start; i < stop; ++i) add_handle(&part, map, i, pivot, &fit.view);
    add_sums(&sums, &part);
  }
  // k itself, in the sum with weight c, has its own share
  real total = fma(pivot->r, sums.weight - pivot->c, pivot->c);
  fit.share = pivot->r / total;
  fit.q = vec_scale(fit.share, sums.q);
  vec u = vec_scale(fit.share, sums.u);
  fit.u = vec_add(pivot->u, u);
  fit.s = vec_sub(pivot->x, fit.q);
  fit.c = sums.c;
  subtract_outer(&fit.c, vec_add(fit.q, u), sums.q);
  if (map->rotation_rank == 2) {
    fit.rotation = whole_rotation(&fit.c);
  } else if (map->rotation_rank == 1) {
    vec a, b;
    line_of(&fit.c, &a, &b);
    fit.rotation = line_rotation(a, b, map->flip_axis);
  } else {
    fit.rotation = (quaternion_t){1, 0, 0, 0};
  }
  fit.factor = 0;
#if SIMILARITY
  mat turn = turn_of(fit.rotation);
  mat s = turned_back(&turn, &fit.c);
  fit.spread = sums.spread - dot3(fit.q, sums.q);
  integer flat = fit.spread <= 1e-30f;
  real r_max = s.a[0] + s.a[4] + s.a[8];
  fit.factor = select((r_max - fit.spread) / fit.spread, (real)(0), flat);
#endif
  return fit;
}

// G(v) - v - drift.
inline vec displacement_of(const map_t *map, const fit_t *fit) {
  mat turn = turn_of(fit->rotation);
  vec moved = mat_vec(&turn, fit->s);
#if SIMILARITY
  moved = vec_madd(fit->factor, vec_add(moved, fit->s), moved);
#endif
  return vec_add(fit->u, moved);
}

// d(G - v)/dv, rows by the component of G. The weights change the optimum only through each
// control point's residual; its influence on G(v) is derived in vtk_mls/reference.py.
inline mat displacement_jacobian(const map_t *map, const fit_t *fit) {
  const pivot_t *pivot = &fit->pivot;
  vec near = pivot_slope(map, pivot, &fit->view);
  mat turn = turn_of(fit->rotation), rotation = turn, c = fit->c;
  for (int i = 0; i < 9; i += 4) rotation.a[i] += 1;
  mat s = turned_back(&turn, &c);
  real mu = 1 + fit->factor;
  vec turned_s = mat_vec(&rotation, fit->s), moved = vec_scale(mu, turned_s);
  real stiffness[6], flexibility[6];
  stiffness_of(&s, stiffness);
  invert_symmetric(stiffness, flexibility);
  vec a, b;
  line_of(&c, &a, &b);
  vec both = vec_add(a, b);
  real strength = 1 / most(s.a[0] + s.a[4] + s.a[8], 1e-30f);
  real opening = 1 / most(1 + dot3(a, b), 1e-10f);

  mat jacobian = {{0}};
  for (int i = 0; i < map->count; ++i) {
    __global const float *handle = map->handles + (long)i * HANDLE_SIZE;
    real w = handle_weight(map, i, pivot, &fit->view);
    vec slope = vec_scale(w, vec_sub(weight_slope(map, i, &fit->view), near));
    vec q = {handle[0] - pivot->q.x - fit->q.x, handle[1] - pivot->q.y - fit->q.y,
             handle[2] - pivot->q.z - fit->q.z};
    vec p = {q.x + (handle[4] - fit->u.x), q.y + (handle[5] - fit->u.y),
             q.z + (handle[6] - fit->u.z)};
    vec turned = mat_vec(&rotation, q);
    vec influence = vec_scale(fit->share, vec_madd(-mu, turned, p));
    if (map->rotation_rank == 2) {
      vec torque = cross3(q, transposed_mat_vec(&rotation, p));
      vec omega = mat_vec(&rotation, symmetric_vec(flexibility, torque));
      influence = vec_add(influence, cross3(omega, moved));
    } else if (map->rotation_rank == 1) {
      vec da = vec_scale(strength * dot3(q, b), vec_madd(-dot3(p, a), a, p));
      vec db = vec_scale(strength * dot3(p, a), vec_madd(-dot3(q, b), b, q));
      vec omega = vec_sub(cross3(both, da), mat_vec(&rotation, cross3(both, db)));
      influence = vec_madd(opening, cross3(omega, moved), influence);
    }
#if SIMILARITY
    real stretch = dot3(p, turned) - mu * dot3(q, q);
    integer flat = fit->spread <= 1e-30f;
    influence = vec_madd(select(stretch / fit->spread, (real)(0), flat), turned_s, influence);
#endif
    add_outer(&jacobian, influence, slope);
  }
  for (int i = 0; i < 9; ++i) jacobian.a[i] += fma(fit->factor, rotation.a[i], turn.a[i]);
  return jacobian;
}
