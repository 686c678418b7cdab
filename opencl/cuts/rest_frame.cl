// Cuts that belong to the material see it in the undeformed space: control point i at p_i, and the
// material at its origin x. So the map is the fixed point x = G(v; damping as seen from x).
//
// The search for x starts at the affine map that fits all control points best, or on grids nearer
// (origin_nodes.cl). After a step across a cut the search goes on as if the cut were still ahead (bit i
// of `crossed_cuts`): its blocking is exchanged, and the map is continued smoothly behind the face. If
// the search ends there, the material on that side of the cut does not reach v; a second search for
// the other side starts from that end. If it ends behind the cut too, v is void.

#define MAX_ROUNDS 12            // of one search
// Tolerances relative to the size of x: the residual, the error estimated from two residuals, and the
// error estimated from the first residual if the slope of the map is given.
#define CONVERGED 3e-7f
#define CONVERGED_BY_RATE 3e-8f
#define ACCURATE_START 4e-7f
#define MAX_DEPTH_RATIO2 (4 * 4)  // squared depth behind a cut, in residuals, at which a search fails

// Whether a cut hides any of the control points from the point's view.
inline integer hides_any(const map_t *map, const evaluation_point_t *point) {
  integer hidden = 0;
  for (int i = 0; i < term_count(map); ++i)
    hidden |= is_hidden(&map->cuts, &point->view, i, cut_target(map, i));
  return hidden;
}

// The start of a search, and the norm of dG/dx there: an error in x times it is one in G.
typedef struct {
  vec x;
  real slope;
} start_t;

#define UNKNOWN_SLOPE 1e15f

// The origin of the material at v by the affine map.
inline start_t affine_start(const map_t *map, vec v) {
  return (start_t){transformed(map->cuts.params.affine, v), UNKNOWN_SLOPE};
}

// A search for x: current x and crossed cuts, last residual and last image.
typedef struct {
  vec x, residual, image;
  integer crossed_cuts, rounds;
  integer has_residual;  // whether `residual` and `image` are set
} search_t;

// Whether the search has converged to an image of this size, by its squared residual.
inline integer has_converged(const search_t *search, real residual2, real size) {
  real last2 = dot3(search->residual, search->residual), limit = CONVERGED_BY_RATE * size;
  return (residual2 <= CONVERGED * CONVERGED * size * size) |
         (search->has_residual & (residual2 * residual2 <= limit * limit * last2));
}

// Sets the next x after the image y: a secant step, by two residuals.
inline void advance(const cuts_t *cuts, search_t *search, vec y, integer active) {
  vec residual = vec_sub(y, search->x), change = vec_sub(residual, search->residual);
  real share = dot3(residual, change) / fast_max(dot3(change, change), 1e-30f);
  share = select((real)(0), fast_min(fast_max(share, (real)(-1)), (real)(1)), search->has_residual);
  vec x = vec_madd(-share, vec_sub(y, search->image), y);
  search->crossed_cuts ^= select((integer)(0), crossed(cuts, search->x, x), active);
  search->residual = vec_select(search->residual, residual, active);
  search->x = vec_select(search->x, x, active);
  search->image = vec_select(search->image, y, active);
  search->has_residual |= active;
}

// Restarts at x where `restarts` is set.
inline void begin(search_t *search, vec x, integer crossed_cuts, integer restarts) {
  search->x = vec_select(search->x, x, restarts);
  search->crossed_cuts = select(search->crossed_cuts, crossed_cuts, restarts);
  search->rounds = select(search->rounds, (integer)(0), restarts);
  search->has_residual &= !restarts;
}

// Up to two searches at v, one at a time, and the last image of the first one if it has failed.
typedef struct {
  vec v;
  real slope;  // at the start, as in start_t
  search_t search;
  vec first;  // image, depth behind the cut and crossed cuts of the failed first search
  real first_depth;
  integer first_crossed;
  integer second, last;  // whether the second search has started, and whether none will follow
} searches_t;

// Starts searches at v from `start` where `restarts` is set. With `one_side` no second search follows.
inline void search_from(searches_t *searches, vec v, start_t start, int one_side, integer restarts) {
  searches->v = vec_select(searches->v, v, restarts);
  searches->slope = select(searches->slope, start.slope, restarts);
  begin(&searches->search, start.x, (integer)(0), restarts);
  searches->second &= !restarts;
  searches->last = select(searches->last, (integer)(one_side ? -1 : 0), restarts);
}

// Evaluates the map once for `active` searches; returns which have ended, at the current fit. If both
// searches fail, the better one is continued to its end.
inline integer evaluate_searches(const map_t *map, searches_t *searches, fit_t *fit,
                                 integer active) {
  const cuts_t *cuts = &map->cuts;
  search_t *search = &searches->search;
  const integer none = 0, is_first = (search->rounds == 0) & !searches->second;
  set_point(cuts, &fit->point, searches->v, search->x);
  fit->point.view.crossed_cuts = search->crossed_cuts;
  fit_map(map, fit);
  vec y = origin_of(cuts, searches->v, map_displacement(map, fit));
  const vec residual = vec_sub(y, search->x);
  const real residual2 = dot3(residual, residual), size = size_of(y), limit = ACCURATE_START * size;
  integer ended = has_converged(search, residual2, size) | (search->rounds >= MAX_ROUNDS - 1);
  ended |= is_first & (searches->slope * searches->slope * residual2 <= limit * limit);
  integer clear = is_first & !ended & !fit->point.view.hides_any;
  if (ANY(active & clear)) {  // no cut may hide any control point from y, either
    evaluation_point_t point;
    set_point(cuts, &point, searches->v, y);
    ended |= clear & !hides_any(map, &point);
  }
  integer retries = none, returns = none;
  integer behind = active & !searches->last & (search->crossed_cuts != 0);
  if (ANY(behind)) {
    real depth = -void_distance_of(cuts, y, y, search->crossed_cuts);
    // those that have ended, and those that will end there
    behind &= ended | ((depth > 0) & (depth * depth > MAX_DEPTH_RATIO2 * residual2));
    retries = behind & !searches->second;
    searches->last |= behind & searches->second;
    returns = behind & searches->second & (searches->first_depth < depth);
    searches->first_depth = select(searches->first_depth, depth, retries);
  }
  active &= !(ended | retries | returns);
  if (ANY(active)) advance(cuts, search, y, active);
  search->rounds += 1;
  if (ANY(retries | returns)) {
    begin(search, searches->first, searches->first_crossed, returns);
    searches->first = vec_select(searches->first, y, retries);
    searches->first_crossed = select(searches->first_crossed, search->crossed_cuts, retries);
    begin(search, y, none, retries);
    searches->second |= retries;
  }
  return ended & !(retries | returns);
}

// The fit at v, for the origin that searches from `start` find.
inline fit_t solve_origin(const map_t *map, vec v, start_t start) {
  integer active = (real)(0) == 0;
  searches_t searches = {v};
  search_from(&searches, v, start, 0, active);
  fit_t fit;
  while (ANY(active)) active &= !evaluate_searches(map, &searches, &fit, active);
  return fit;
}

inline fit_t fit_at(const map_t *map, vec v) {
  return solve_origin(map, v, affine_start(map, v));
}

#include "origin_nodes.cl"

// Loads point i into a lane.
inline void load_lane(vec *x, int l, __global const float *planes, long count, long i) {
  set_lane(x, l, (float3)(planes[i], planes[i + count], planes[i + 2 * count]));
}

// Vectors of points of a work item. GPUs have one lane, and need many work items.
#define VECTORS (LANES > 1 ? 16 : 1)

// Stores displacements at points in three planes, and void distances in a fourth. Searches start at `starts`
// and stay on their side of the cuts; if null, at the affine map. A lane whose search ends continues with
// the next point, so that no lane waits for the slowest. Every VECTORS-th work item does the work of
// VECTORS items.
inline void displace_points(const map_t *map, long count, __global const float *points,
                            __global const float *starts, __global float *displacement) {
  const long first = (long)get_global_id(0) * LANES;
  if (get_global_id(0) % VECTORS != 0 || first >= count) return;
  const int stop = (int)min(count - first, (long)(VECTORS * LANES));
  searches_t searches = {{0}};
  fit_t fit;
  integer at = 0, ended = (real)(0) == 0, active = ended;
  vec v = {0, 0, 0};
  start_t start = {v, UNKNOWN_SLOPE};
  for (int next = 0;;) {
    for (int l = 0; l < LANES; ++l) {
      if (!LANE_INT(ended, l)) continue;
      LANE_INT(active, l) = next < stop ? -1 : 0;
      LANE_INT(at, l) = min(next++, stop - 1);
      load_lane(&v, l, points, count, first + LANE_INT(at, l));
      if (starts) load_lane(&start.x, l, starts, count, first + LANE_INT(at, l));
    }
    if (!ANY(active)) return;
    if (!starts) start = affine_start(map, v);
    search_from(&searches, v, start, starts != 0, ended & active);
    ended = evaluate_searches(map, &searches, &fit, active) & active;
    if (!ANY(ended)) continue;
    const vec d = map_displacement(map, &fit);
    const real void_distance = void_distance_at(map, &fit, d);
    for (int l = 0; l < LANES; ++l) {
      if (!LANE_INT(ended, l)) continue;
      __global float *to = displacement + first + LANE_INT(at, l);
      to[0] = LANE(d.x, l);
      to[count] = LANE(d.y, l);
      to[2 * count] = LANE(d.z, l);
      to[3 * count] = LANE(void_distance, l);
    }
  }
}

// d(G - v)/dv from both parts of the Jacobian: the origin x, from which cuts see, moves too.
inline mat with_moving_origin(const weight_jacobian_t *jacobian) {
  mat d_dv = jacobian->d_dv, d_dx = jacobian->d_dx, by_x_less;
  for (int i = 0; i < 9; ++i) by_x_less.a[i] = -d_dx.a[i];
  for (int column = 0; column < 3; ++column) {
    vec right = vec_add(mat_column(&d_dv, column), mat_column(&d_dx, column));
    set_mat_column(&d_dv, column, identity_solve(&by_x_less, right));
  }
  return d_dv;
}

inline mat map_jacobian(const map_t *map, const fit_t *fit) {
  weight_jacobian_t jacobian = map_weight_jacobian(map, fit);
  return with_moving_origin(&jacobian);
}
