// The rigid and similarity kinds, Eq. 8 to 22: p = mu R (q - q*) + p*.
//
// Where two control points outweigh all others by far, or all are near a line, rounding of C loses the
// twist about that line. There C is summed again with p and q reflected so that the line is the x axis:
// the twist then has rows and columns of its own.
//
// Build constants: SIMILARITY, CUTS, AT_REST, REGIONS, SEGMENTS.

#include "rotation.cl"

// Distance between the roots of Eq. 22 below which the twist is ill-conditioned.
#define ILL_CONDITIONED_ROOTS 0.3f

typedef struct {
  evaluation_point_t point;
  pivot_t pivot;
  real share;       // r / W: weight of the sums next to the total weight
  vec u;            // p* - q*, less the mean displacement
  vec s;            // v - q*
  quaternion_t rotation;
  integer ill_conditioned;  // lanes that are reflected
  vec p_mirror, q_mirror;  // normals of their reflections
  vec p, q;         // p* - p_k and q* - q_k, reflected
  mat c;            // C of Eq. 11, divided by r, reflected
  quaternion_t between;    // the rotation from q to p, reflected
  real factor;      // mu - 1
  real spread;      // sum of w |q - q*|^2, divided by r
} fit_t;

typedef struct {
  real weight;
  vec q, u;
  mat c;
  real spread;  // of similarities
} sums_t;

// Adds a point to the sums of weights, q and u = p - q, relative to k.
HOT void add_means(sums_t *sums, real w, vec q, vec u) {
  sums->weight += w;
  sums->q = vec_madd(w, q, sums->q);
  sums->u = vec_madd(w, u, sums->u);
}

// Adds a point to all sums.
HOT void add_pair(sums_t *sums, real w, vec q, vec u) {
  add_means(sums, w, q, u);
  add_outer(&sums->c, vec_add(q, u), vec_scale(w, q));
  if (SIMILARITY) sums->spread = fma(w, dot3(q, q), sums->spread);
}

// Adds segments, whose points are q + t along_q, by the moments of their weights about the mean.
inline void add_segments(sums_t *sums, const map_t *map, int first, int stop, const pivot_t *pivot,
                         const evaluation_point_t *point) {
  for (; first < stop; first += SEGMENT_GROUP) {
    segment_weight_t weights[SEGMENT_GROUP];
    const int count = min(stop - first, SEGMENT_GROUP);
    for (int j = 0; j < count; ++j)
      weights[j] = segment_weight(map, first + j, pivot, point, 0, TOP);
    for (int j = 0; j < count; ++j) {
      const placed_segment_t at = placed_segment(map, first + j, pivot, weights + j);
      add_pair(sums, weights[j].m[0], at.q, at.u);
      const vec wtq = vec_scale(weights[j].m[2], at.along_q);
      add_outer(&sums->c, vec_add(at.along_q, at.along_u), wtq);
      if (SIMILARITY) sums->spread += dot3(at.along_q, wtq);
    }
  }
}

inline void add_sums(sums_t *total, const sums_t *part) {
  total->weight += part->weight;
  total->q = vec_add(total->q, part->q);
  total->u = vec_add(total->u, part->u);
  UNROLL_ALL for (int i = 0; i < 9; ++i) total->c.a[i] += part->c.a[i];
  if (SIMILARITY) total->spread += part->spread;
}

// Adds the products p q^T and the squares of q of a control point, of a region those of its proxies.
HOT void add_products(sums_t *sums, const map_t *map, int i, real w, vec q, vec u) {
  add_outer(&sums->c, vec_add(q, u), vec_scale(w, q));
  if (SIMILARITY) sums->spread = fma(w, dot3(q, q), sums->spread);
  if (!is_region(map, i)) return;
  UNROLL_ALL for (int j = 0; j < 9; ++j)
    sums->c.a[j] = fma((real)(map->regions[i].moments[j]), w, sums->c.a[j]);
  if (SIMILARITY) sums->spread = fma((real)(map->regions[i].spread), w, sums->spread);
}

// A control point relative to a k that all lanes share: q, and u after the difference of the factors c.
typedef struct { float4 q, u; } shared_pair_t;

// Both give the same floats.
HOT pair_t shared_or_own_pair(const shared_pair_t *shared, __global const control_point_t *at,
                              const pivot_t *pivot, const int is_shared) {
  pair_t pair;
  if (is_shared) {
    pair.q = (vec){shared->q.x, shared->q.y, shared->q.z};
    pair.u = (vec){shared->u.y, shared->u.z, shared->u.w};
  } else {
    set_pair(&pair, at, pivot);
  }
  return pair;
}

// Adds the sums of a group; `is_shared` is a constant: whether all lanes share k.
HOT void add_group(sums_t *sums, const map_t *map, int first, int count, const pivot_t *pivot,
                   const evaluation_point_t *point, const int is_shared) {
  __global const control_point_t *at = control_point_of(map, first);
  shared_pair_t shared[TERM_GROUP];
  if (is_shared) {
    __global const control_point_t *k = control_point_of(map, LANE_INT(pivot->k, 0));
    const float4 q = vload4(0, k->q), u = vload4(0, &k->c);
    for (int j = 0; j < count; ++j)
      shared[j] = (shared_pair_t){vload4(0, at[j].q) - q, vload4(0, &at[j].c) - u};
  }
  real weights[TERM_GROUP];
  set_weights(weights, map, first, count, pivot, point);
  sums_t part = {0};
  for (int j = 0; j < count; ++j) {
    const pair_t pair = shared_or_own_pair(shared + j, at + j, pivot, is_shared);
    const real w = weight_in_group(weights, map, first, j, pivot, point);
    add_means(&part, w, pair.q, pair.u);
#if HAS_FEW_REGISTERS
  }
  for (int j = 0; j < count; ++j) {
    const pair_t pair = shared_or_own_pair(shared + j, at + j, pivot, is_shared);
    const real w = weights[j];
#endif
    add_products(&part, map, first + j, w, pair.q, pair.u);
  }
  add_sums(sums, &part);
}

// A vector in the reflected frame of p or q, or out of it.
inline vec reflected(const fit_t *fit, vec normal, vec a) {
  if (ANY(fit->ill_conditioned)) a = mirrored(normal, a);
  return a;
}

inline vec on_axis(vec a, integer ill_conditioned) {
  integer rounding = ill_conditioned & (fma(a.y, a.y, a.z * a.z) < 1e-12f * a.x * a.x);
  return (vec){a.x, select(a.y, (real)(0), rounding), select(a.z, (real)(0), rounding)};
}

// p - p_k and q - q_k of a point, reflected in ill-conditioned lanes; rounding off the x axis becomes 0.
inline void reflected_pair(const fit_t *fit, vec *p, vec *q, vec u) {
  *p = vec_add(*q, u);
  if (ANY(fit->ill_conditioned)) {
    *p = on_axis(mirrored(fit->p_mirror, *p), fit->ill_conditioned);
    *q = on_axis(mirrored(fit->q_mirror, *q), fit->ill_conditioned);
  }
}

// Reflects ill-conditioned lanes by the control point that adds most to C, and fits them again.
inline void reflect(const map_t *map, fit_t *fit) {
  const pivot_t *pivot = &fit->pivot;
  real heaviest = 0;
  vec p_axis = {0, 0, 0}, q_axis = {0, 0, 0};
  for (int i = 0; i < term_count(map); ++i) {
    pair_t pairs[PAIRS];
    const int count = pairs_of(map, i, pivot, &fit->point, pairs);
    for (int j = 0; j < count; ++j) {
      vec q = pairs[j].q, p = vec_add(q, pairs[j].u);
      real w = pairs[j].w, size = w * w * dot3(p, p) * dot3(q, q);
      p_axis = vec_select(p_axis, p, size > heaviest);
      q_axis = vec_select(q_axis, q, size > heaviest);
      heaviest = fast_max(heaviest, size);
    }
  }
  const vec none = {0, 0, 0};
  fit->ill_conditioned &= heaviest > 0;
  fit->p_mirror = vec_select(none, mirror_of(p_axis), fit->ill_conditioned);
  fit->q_mirror = vec_select(none, mirror_of(q_axis), fit->ill_conditioned);
  sums_t sums = {0};
  int block = block_of(map);
  for (int start = 0; start < term_count(map); start += block) {
    sums_t part = {0};
    int stop = min(start + block, term_count(map));
    for (int i = start; i < stop; ++i) {
      pair_t pairs[PAIRS];
      const int count = pairs_of(map, i, pivot, &fit->point, pairs);
      for (int j = 0; j < count; ++j) {
        vec p, q = pairs[j].q;
        reflected_pair(fit, &p, &q, pairs[j].u);
        add_pair(&part, pairs[j].w, q, vec_sub(p, q));
      }
    }
    add_sums(&sums, &part);
  }
  vec q = vec_scale(fit->share, sums.q), p = vec_madd(fit->share, sums.u, q);
  add_outer(&sums.c, vec_scale((real)(-1), p), sums.q);
  fit->p = vec_select(fit->p, p, fit->ill_conditioned);
  fit->q = vec_select(fit->q, q, fit->ill_conditioned);
  for (int i = 0; i < 9; ++i)
    fit->c.a[i] = select(fit->c.a[i], sums.c.a[i], fit->ill_conditioned);
  real slope;
  quaternion_t between = whole_rotation(&sums.c, &slope);
  fit->between = select4(fit->between, between, fit->ill_conditioned);
  fit->rotation = select4(fit->rotation, unmirrored(fit->p_mirror, between, fit->q_mirror),
                          fit->ill_conditioned);
}

// Fits the map at fit->point.
inline void fit_step(const map_t *map, fit_t *fit) {
  fit->pivot = find_pivot(map, &fit->point);
  const pivot_t *pivot = &fit->pivot;
  const integer k = pivot->k;
  // with 32 registers scalar differences gain nothing
  const int is_shared =
      HAS_FEW_REGISTERS && LANE_INT(k, 0) < map->params.count && !ANY(k != LANE_INT(k, 0));
  sums_t sums = {0}, of_many = {0};  // groups, and groups of groups, which rounds less
  const int block = block_of(map);
  for (int first = 0; first < map->params.count; first += TERM_GROUP) {
    const int count = min(map->params.count - first, TERM_GROUP);
    if (is_shared)
      add_group(&sums, map, first, count, pivot, &fit->point, 1);
    else
      add_group(&sums, map, first, count, pivot, &fit->point, 0);
    if (block > TERM_GROUP && first / TERM_GROUP % TERM_GROUP == TERM_GROUP - 1) {
      add_sums(&of_many, &sums);
      sums = (sums_t){0};
    }
  }
  if (block > TERM_GROUP) add_sums(&sums, &of_many);
  for (int start = map->params.count; SEGMENTS && start < term_count(map); start += block) {
    sums_t part = {0};
    add_segments(&part, map, start, min(start + block, term_count(map)), pivot, &fit->point);
    add_sums(&sums, &part);
  }
  // k itself, in the sum with weight c, has its own share
  real total = fma(pivot->r, sums.weight - pivot->c, pivot->c);
  fit->share = pivot->r / total;
  vec q = vec_scale(fit->share, sums.q), u = vec_scale(fit->share, sums.u);
  fit->u = vec_add(pivot->u, u);
  fit->s = vec_sub(pivot->x, q);
  fit->p = vec_add(q, u);
  fit->q = q;
  fit->c = sums.c;
  add_outer(&fit->c, vec_scale((real)(-1), fit->p), sums.q);
  fit->ill_conditioned = (integer)(0);
  if (map->params.rank == 2) {
    real slope;
    fit->between = fit->rotation = whole_rotation(&fit->c, &slope);
    fit->ill_conditioned = slope < ILL_CONDITIONED_ROOTS;
    if (ANY(fit->ill_conditioned)) reflect(map, fit);
  } else if (map->params.rank == 1) {
    vec a, b;
    line_of(&fit->c, &a, &b);
    const float *axis = map->params.flip_axis;
    fit->between = fit->rotation = line_rotation(a, b, (float4)(axis[0], axis[1], axis[2], 0));
  } else {
    fit->between = fit->rotation = (quaternion_t){1, 0, 0, 0};
  }
  fit->factor = 0;
  if (!SIMILARITY) return;
  mat change = rotation_change(fit->between);
  mat s = rotated_back(&change, &fit->c);
  fit->spread = sums.spread - dot3(q, sums.q);
  integer flat = fit->spread <= 1e-30f;
  real r_max = s.a[0] + s.a[4] + s.a[8];
  fit->factor = select((r_max - fit->spread) / fit->spread, (real)(0), flat);
}

// G(v) - v - mean displacement.
inline vec displacement_of(const map_t *map, const fit_t *fit) {
  mat change = rotation_change(fit->rotation);
  vec moved = mat_vec(&change, fit->s);
  if (SIMILARITY) moved = vec_madd(fit->factor, vec_add(moved, fit->s), moved);
  return vec_add(fit->u, moved);
}

// The change of G(v) with the torque on the rotation, in the frame of q: t to (F t) x s.
inline mat lever_of(const real flexibility[6], vec s) {
  mat lever;
  for (int axis = 0; axis < 3; ++axis) {
    const vec unit = {axis == 0, axis == 1, axis == 2};
    set_mat_column(&lever, axis, cross3(symmetric_vec(flexibility, unit), s));
  }
  return lever;
}

// The columns of derivatives, turned from the frame of q by `rotation` and reflected out of that of p.
inline void turn_columns(const fit_t *fit, const mat *rotation, mat *j) {
  for (int column = 0; column < 3; ++column) {
    const vec turned = mat_vec(rotation, mat_column(j, column));
    set_mat_column(j, column, reflected(fit, fit->p_mirror, turned));
  }
}

// The rotation R from the frame of q to that of p, S = R^T C, and the inverse of the stiffness of S.
typedef struct {
  mat rotation, s;
  real flexibility[6];
} flexible_t;

inline flexible_t flexible_rotation(const fit_t *fit) {
  flexible_t at;
  const mat change = rotation_change(fit->between);
  at.rotation = change;
  UNROLL_ALL for (int i = 0; i < 9; i += 4) at.rotation.a[i] += 1;
  at.s = rotated_back(&change, &fit->c);
  real stiffness[6];
  stiffness_of(&at.s, stiffness);
  invert_symmetric(stiffness, at.flexibility);
  return at;
}

// d(G - v)/dv, rows by the component of G. The weights change the optimum only through each
// control point's residual; its influence on G(v) is derived in
// vtk_mls/reference/reference_engine.py. It is summed in the frame of q.
inline weight_jacobian_t displacement_jacobian(const map_t *map, const fit_t *fit) {
  const pivot_t *pivot = &fit->pivot;
  const flexible_t flexible = flexible_rotation(fit);
  const mat rotation = flexible.rotation, c = fit->c;
  const real mu = 1 + fit->factor;
  const vec at = reflected(fit, fit->q_mirror, fit->s), moved = vec_scale(mu, at);
  const mat lever = lever_of(flexible.flexibility, moved);
  vec a = {0, 0, 0}, b = a, both = a;
  real strength = 0, gain = 0;
  if (map->params.rank == 1) {  // a tenth of the time of a Jacobian by 15 points
    line_of(&c, &a, &b);
    both = vec_add(a, b);
    strength = 1 / fast_max(flexible.s.a[0] + flexible.s.a[4] + flexible.s.a[8], 1e-30f);
    gain = 1 / fast_max(1 + dot3(a, b), 1e-10f);
  }

  weight_jacobian_t jacobian = no_weight_jacobian(map, pivot, &fit->point);
  for (int i = 0; i < term_count(map); ++i) {
    change_t changes[CHANGES];
    const int count = changes_of(map, i, pivot, &fit->point, &jacobian, changes);
    for (int j = 0; j < count; ++j) {
      vec p, q = changes[j].q;
      reflected_pair(fit, &p, &q, changes[j].u);
      p = vec_sub(p, fit->p);
      q = vec_sub(q, fit->q);
      const vec turned = transposed_mat_vec(&rotation, p);
      vec influence = vec_scale(fit->share, vec_madd(-mu, q, turned));
      if (map->params.rank == 2) {
        influence = vec_add(influence, mat_vec(&lever, cross3(q, turned)));
      } else if (map->params.rank == 1) {
        vec da = vec_scale(strength * dot3(q, b), vec_madd(-dot3(p, a), a, p));
        vec db = vec_scale(strength * dot3(p, a), vec_madd(-dot3(q, b), b, q));
        vec omega = vec_sub(transposed_mat_vec(&rotation, cross3(both, da)), cross3(both, db));
        influence = vec_madd(gain, cross3(omega, moved), influence);
      }
      if (SIMILARITY) {
        real stretch = dot3(turned, q) - mu * dot3(q, q);
        integer flat = fit->spread <= 1e-30f;
        influence = vec_madd(select(stretch / fit->spread, (real)(0), flat), at, influence);
      }
      add_influence(&jacobian, changes + j, influence);
    }
  }
  turn_columns(fit, &rotation, &jacobian.d_dv);
  if (AT_REST) turn_columns(fit, &rotation, &jacobian.d_dx);
  const mat change = rotation_change(fit->rotation);
  for (int i = 0; i < 9; ++i)
    jacobian.d_dv.a[i] += change.a[i] + fit->factor * (change.a[i] + (i % 4 == 0 ? 1.0f : 0.0f));
  return jacobian;
}

#define HAS_TRANSPOSED_JACOBIAN ONLY_CONTROL_POINTS
// The influence of a control point on n . G(v), as a function of p and q relative to k:
// p . (form q + offset) - linear . q + rest, of a similarity less squares |q - q*|^2.
typedef struct {
  mat form;
  vec offset, linear;
  real rest, squares;
} influence_t;

inline influence_t influence_of(const fit_t *fit, vec n) {
  const flexible_t flexible = flexible_rotation(fit);
  const real mu = 1 + fit->factor;
  const vec back = vec_scale(mu, transposed_mat_vec(&flexible.rotation, n));
  const vec turn = symmetric_vec(flexible.flexibility, cross3(fit->s, back));
  influence_t influence;
  real stretch = 0;
  if (SIMILARITY) {
    const integer flat = fit->spread <= 1e-30f;
    stretch = select(dot3(fit->s, back) / (mu * fit->spread), (real)(0), flat);
  }
  influence.squares = mu * stretch;
  // R ([turn]x + stretch I)
  UNROLL_ALL for (int i = 0; i < 3; ++i) {
    const vec row = mat_row(&flexible.rotation, i);
    vec turned = cross3(row, turn);
    if (SIMILARITY) turned = vec_madd(stretch, row, turned);
    set_mat_row(&influence.form, i, turned);
  }
  const vec shared = vec_scale(fit->share, back);
  influence.offset = vec_sub(vec_scale(fit->share, n), mat_vec(&influence.form, fit->q));
  influence.linear = vec_add(shared, transposed_mat_vec(&influence.form, fit->p));
  influence.rest = dot3(shared, fit->q) - dot3(fit->p, influence.offset);
  return influence;
}

// Whether transposed_displacement_jacobian() is as exact as displacement_jacobian().
inline int is_transposed_jacobian_exact(const map_t *map, const fit_t *fit) {
  return map->params.rank == 2 && !ANY(fit->ill_conditioned);
}

// d(n . (G - v))/dv, as displacement_jacobian() has it.
inline vec transposed_displacement_jacobian(const map_t *map, const fit_t *fit, vec n) {
  const influence_t influence = influence_of(fit, n);
  gains_t gains = {0, {0, 0, 0}};
  for (int i = 0; i < map->params.count; ++i) {
    pair_t pair;
    set_pair(&pair, control_point_of(map, i), &fit->pivot);
    const vec q = pair.q, by_p = vec_add(influence.offset, mat_vec(&influence.form, q));
    real gain = dot3(vec_add(q, pair.u), by_p) - dot3(influence.linear, q) + influence.rest;
    if (SIMILARITY) {
      const vec off = vec_sub(q, fit->q);
      gain = fma(-influence.squares, dot3(off, off), gain);
    }
    add_gain(&gains, map, i, &fit->pivot, q, gain);
  }
  const mat change = rotation_change(fit->rotation);
  const vec turned = transposed_mat_vec(&change, n);
  const vec fixed = vec_madd(fit->factor, vec_add(turned, n), turned);  // at fixed weights
  return vec_add(fixed, slope_of_gains(&gains, map, &fit->pivot, &fit->point));
}
