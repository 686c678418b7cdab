// The terms of the sums of a fit as points: a control point is one, a rigid region its proxies, a
// segment of a curve a few that have the moments of its weight along it (segments.cl).
//
// Build constants: CUTS, AT_REST, REGIONS, SEGMENTS, STEPS, LIMITS, LANES, TWICE_ALPHA.

// A point of a term, relative to k: q, u, and its weight relative to that of the second nearest.
typedef struct {
  vec q, u;
  real w;
} pair_t;

// The most points of a term; REGIONS is that of a region.
#define PAIRS (SEGMENT_POINTS > REGIONS ? SEGMENT_POINTS : REGIONS)
#define CHANGES (2 * SEGMENTS > PAIRS ? 2 * SEGMENTS : PAIRS)

// The weight of a segment along it as seen from v: moments about a share of its length, which is
// `from_nearest` from that of the nearest point, `t`. For degree 1 it is the mean, without slopes;
// else that of the nearest point, or 1/2.
typedef struct {
  real t, from_nearest, m[MOMENTS];
} segment_weight_t;

// Moments up to `top`. With `slopes`, for weights divided by the squared distance.
HOT segment_weight_t segment_weight(const map_t *map, int i, const pivot_t *pivot,
                                    const evaluation_point_t *point, int slopes, const int top) {
  __global const segment_t *at = segment_of(map, i);
  const nearest_t nearest = found_on_segment(map, i, point);
  const float smoothing2 = map->params.smoothing2;
  segment_weight_t weight;
  weight.t = nearest.t;
  real e2 = pivot->e2, c = at->c;
  if (CUTS) {
    e2 = select(e2, (real)(1), is_unreachable(e2));  // no segment but the pivot can be reached
    integer hides_any = 0;
    const real damping =
        i < CACHED ? point->distance2[i] : segment_damping(map, i, point, &hides_any);
    c = select(c / whole_power(damping, INTEGER_ALPHA), (real)(0), is_unreachable(damping));
  }
  weight.from_nearest = weight_moments(at, &nearest, smoothing2, e2, slopes, top, c, weight.m);
  return weight;
}

// A segment, and its point of share t, about which are the moments, relative to k.
typedef struct {
  vec q, u, along_q, along_u;
  real t;
} placed_segment_t;

HOT placed_segment_t placed_segment(const map_t *map, int i, const pivot_t *pivot,
                                    const segment_weight_t *weight) {
  __global const segment_t *at = segment_of(map, i);
  placed_segment_t result;
  result.t = weight->t + weight->from_nearest;
  result.along_q = load3(at->along_q);
  result.along_u = load3(at->along_u);
  const integer is_pivot = pivot->k == i;
  const vec none = {0, 0, 0};
  vec q = vec_sub(load3(at->q), pivot->q), u = vec_sub(load3(at->u), pivot->u);
  real t = result.t;
  if (ANY(is_pivot)) {  // k is the nearest point then
    q = vec_select(q, none, is_pivot);
    u = vec_select(u, none, is_pivot);
    t = select(t, weight->from_nearest, is_pivot);
  }
  result.q = vec_madd(t, result.along_q, q);
  result.u = vec_madd(t, result.along_u, u);
  return result;
}

// The weights of this many segments are computed in one loop and added in another. A processor
// overlaps the rounds of a short loop. Above degree 1 the rounds are too long for that.
#define SEGMENT_GROUP (SEGMENTS > 2 ? 1 : 16)

// The points of segment i; with `slopes`, for weights divided by the squared distance.
HOT void segment_pairs(const map_t *map, int i, const pivot_t *pivot, const evaluation_point_t *point,
                       int slopes, pair_t pairs[PAIRS]) {
  const int top = SEGMENTS < 4 ? TOP + slopes : TOP + 1;
  const segment_weight_t weight = segment_weight(map, i, pivot, point, slopes, top);
  const placed_segment_t along = placed_segment(map, i, pivot, &weight);
  const rule_t rule = rule_of(weight.m, slopes);
  UNROLL_ALL for (int j = 0; j < SEGMENT_POINTS; ++j) {
    pairs[j].q = vec_madd(rule.t[j], along.along_q, along.q);
    pairs[j].u = vec_madd(rule.t[j], along.along_u, along.u);
    pairs[j].w = rule.w[j];
  }
}

// Control points that are summed at once. Vectors have their weights computed in one loop and added in
// others: 16 registers do not hold all sums, which would be stored and loaded at each control point. A
// processor with vectors of 16 lanes has 32 registers.
#define TERM_GROUP 32
#define HAS_FEW_REGISTERS (LANES > 1 && LANES < 16)

HOT void set_weights(real weights[TERM_GROUP], const map_t *map, int first, int count,
                     const pivot_t *pivot, const evaluation_point_t *point) {
  for (int j = 0; LANES > 1 && j < count; ++j)
    weights[j] = control_point_weight(map, first + j, pivot, point);
}

// The weight j of a group, in one lane computed now.
HOT real weight_in_group(const real weights[TERM_GROUP], const map_t *map, int first, int j,
                         const pivot_t *pivot, const evaluation_point_t *point) {
  return LANES > 1 ? weights[j] : control_point_weight(map, first + j, pivot, point);
}

// Sets the place of a control point relative to k.
HOT void set_pair(pair_t *pair, __global const control_point_t *at, const pivot_t *pivot) {
  pair->q = vec_sub(load3(at->q), pivot->q);
  pair->u = vec_sub(load3(at->u), pivot->u);
}

// The points of term i; returns how many.
HOT int pairs_of(const map_t *map, int i, const pivot_t *pivot, const evaluation_point_t *point,
                 pair_t pairs[PAIRS]) {
  if (is_segment(map, i)) {
    segment_pairs(map, i, pivot, point, 0, pairs);
    return SEGMENTS;
  }
  __global const control_point_t *at = control_point_of(map, i);
  pairs->w = control_point_weight(map, i, pivot, point);
  if (is_region(map, i)) {
    __global const region_t *region = map->regions + i;
    const real share = pairs->w / at->c;
    at = control_point_of(map, map->params.count + region->first_proxy);
    for (int j = 0; j < region->proxy_count; ++j, ++at) {
      set_pair(pairs + j, at, pivot);
      pairs[j].w = share * at->c;
    }
    return region->proxy_count;
  }
  set_pair(pairs, at, pivot);
  return 1;
}

// A point of a term, relative to k, and the change of its weight: by v, and by the origin x.
typedef struct {
  vec q, u, d_dv, d_dx;
} change_t;

// The changes of the first `count` points of term i by what changes the weight of all of them.
HOT void set_changes(const map_t *map, int i, const evaluation_point_t *point,
                     const weight_jacobian_t *jacobian, const pair_t *pairs, int count,
                     change_t *changes) {
  const vec slope = vec_sub(weight_slope(map, i, point), jacobian->near);
  vec slope_by_x = {0, 0, 0};
  if (AT_REST) slope_by_x = vec_sub(origin_slope(map, i, point), jacobian->near_x);
  for (int j = 0; j < count; ++j) {
    changes[j].q = pairs[j].q;
    changes[j].u = pairs[j].u;
    changes[j].d_dv = vec_scale(pairs[j].w, slope);
    if (AT_REST) changes[j].d_dx = vec_scale(pairs[j].w, slope_by_x);
  }
}

// A control point, or all proxies of a region as one at their mean; returns 1.
HOT int change_of(const map_t *map, int i, const pivot_t *pivot, const evaluation_point_t *point,
                  const weight_jacobian_t *jacobian, change_t *change) {
  pair_t pair;
  set_pair(&pair, control_point_of(map, i), pivot);
  pair.w = control_point_weight(map, i, pivot, point);
  set_changes(map, i, point, jacobian, &pair, 1, change);
  return 1;
}

// The points of term i that change the fit with v; returns how many. The weights w of a segment change by
// their damping, and along it by w 2 alpha (q - v) / d^2 at other points.
HOT int changes_of(const map_t *map, int i, const pivot_t *pivot, const evaluation_point_t *point,
                   const weight_jacobian_t *jacobian, change_t changes[CHANGES]) {
  pair_t pairs[PAIRS];
  const int count = pairs_of(map, i, pivot, point, pairs);
  set_changes(map, i, point, jacobian, pairs, count, changes);
  if (!is_segment(map, i)) return count;
  segment_pairs(map, i, pivot, point, 1, pairs);
  for (int j = 0; j < SEGMENTS; ++j) {
    change_t *change = changes + count + j;
    change->q = pairs[j].q;
    change->u = pairs[j].u;
    change->d_dv = vec_scale(TWICE_ALPHA * pairs[j].w, vec_sub(pairs[j].q, pivot->x));
    change->d_dx = (vec){0, 0, 0};
  }
  return 2 * SEGMENTS;
}

// Adds the influence of a point times the change of its weight.
inline void add_influence(weight_jacobian_t *jacobian, const change_t *change, vec influence) {
  add_outer(&jacobian->d_dv, influence, change->d_dv);
  if (AT_REST) add_outer(&jacobian->d_dx, influence, change->d_dx);
}

// Products with the transposed Jacobian, for maps of control points alone. Each control point adds its
// influence on one number, its gain, times the change of its weight.
#define ONLY_CONTROL_POINTS (!(CUTS || REGIONS || SEGMENTS || STEPS || LIMITS))

// Sums of gains times weights w, and of these times (q - v) / |q - v|^2.
typedef struct {
  real total;
  vec along;
} gains_t;

// Adds that of control point i, which is at q relative to k.
HOT void add_gain(gains_t *gains, const map_t *map, int i, const pivot_t *pivot, vec q, real gain) {
  const vec to = vec_sub(q, pivot->x);
  const real inverse = 1 / fast_max(dot3(to, to) + map->params.smoothing2, 1e-30f);
  const real w = power(fast_min(pivot->e2 * inverse, (real)(1)), map->params.alpha);
  gain *= control_point_of(map, i)->c * w;
  gains->total += gain;
  gains->along = vec_madd(gain * inverse, to, gains->along);
}

// The derivative by v of the sum of gains times weights.
inline vec slope_of_gains(const gains_t *gains, const map_t *map, const pivot_t *pivot,
                          const evaluation_point_t *point) {
  return vec_madd(-gains->total, pivot_slope(map, pivot, point),
                  vec_scale(2 * map->params.alpha, gains->along));
}
