// Cuts that belong to the material: which control points act on it is decided in the undeformed
// space. A cut sees the control point i at p_i, and the material at its own place x. So the map is
// the fixed point x = G(v; damping as seen from x).
//
// The search for x begins where the affine map that fits all control points best has it, on grids
// nearer (origin_nodes.cl). A step that passes a cut goes on as if the cut were still ahead (bit i of
// `passed`): what blocks is exchanged, and the map continued smoothly behind the face. If it ends
// there, the material on that side of the cut does not reach v; the other side gets a search of its
// own, from that place. If that ends behind the cut too, v is void.

#define ROUNDS 12       // of one search
#define SETTLED 3e-7f   // next to the size of x: a residual that ends it, ...
#define FORESEEN 3e-8f  // ... what two residuals say of the error that is left, ...
#define GUESSED 1e-7f   // ... and what the first does if the slope of the map is known
#define LOST 4          // a search has failed that is so many residuals behind a cut

// Whether a cut hides any of the control points from view->seen.
inline integer hides(const map_t *map, const view_t *view) {
  integer hidden = 0;
  for (int i = 0; i < map->numbers.count; ++i)
    hidden |= is_hidden(&map->cuts, view, i, seen_point(map, control_point_of(map, i)));
  return hidden;
}

// Where a search begins, and the norm of dG/dx there: by it an error in x becomes one in G.
typedef struct {
  vec x;
  real slope;
} start_t;

#define UNKNOWN_SLOPE 1e15f

// A start where the affine map has the material that is at v.
inline start_t affine_start(const map_t *map, vec v) {
  return (start_t){transformed(map->cuts.numbers.affine, v), UNKNOWN_SLOPE};
}

// A search for x: where it is, from behind which cuts it sees, its last residual and where that led.
typedef struct {
  vec x, residual, led;
  integer passed, rounds;
  integer stepped;  // whether there is a last residual
} search_t;

// Whether y, to where the map has led, is x.
inline integer is_settled(const search_t *search, vec y) {
  vec residual = vec_sub(y, search->x);
  real left2 = dot3(residual, residual), before2 = dot3(search->residual, search->residual);
  real size = size_of(y), foreseen = FORESEEN * size;
  return (left2 <= SETTLED * SETTLED * size * size) |
         (search->stepped & (left2 * left2 <= foreseen * foreseen * before2));
}

// The same for the first y.
inline integer is_foreseen(const start_t *start, vec y) {
  vec residual = vec_sub(y, start->x);
  real foreseen = GUESSED * size_of(y);
  return start->slope * start->slope * dot3(residual, residual) <= foreseen * foreseen;
}

// Whether a search that the map has led to y, behind a cut by `depth`, will end behind it.
inline integer is_lost(const search_t *search, vec y, real depth) {
  vec residual = vec_sub(y, search->x);
  return (depth > 0) & (depth * depth > LOST * LOST * dot3(residual, residual));
}

// The next x after the map has led to y: two residuals tell how much is left.
inline void advance(const cuts_t *cuts, search_t *search, vec y, integer going) {
  vec residual = vec_sub(y, search->x), change = vec_sub(residual, search->residual);
  real share = dot3(residual, change) / most(dot3(change, change), 1e-30f);
  share = select((real)(0), least(most(share, (real)(-1)), (real)(1)), search->stepped);
  vec x = vec_madd(-share, vec_sub(y, search->led), y);
  search->passed ^= select((integer)(0), crossed(cuts, search->x, x), going);
  search->residual = vec_select(search->residual, residual, going);
  search->x = vec_select(search->x, x, going);
  search->led = vec_select(search->led, y, going);
  search->stepped |= going;
}

// Begins anew at x, where `anew`.
inline void begin(search_t *search, vec x, integer passed, integer anew) {
  search->x = vec_select(search->x, x, anew);
  search->passed = select(search->passed, passed, anew);
  search->rounds = select(search->rounds, (integer)(0), anew);
  search->stepped &= !anew;
}

// Up to two searches at v, of which one is under way, and where the first has led if it has failed.
typedef struct {
  vec v;
  real slope;  // where they began, as of start_t
  search_t search;
  vec first;
  real first_depth;
  integer first_passed;
  integer second, last;  // whether there has been a second one, and whether there will be none
} searches_t;

// Searches at v from `start` where `anew`; with `stays` there is no other side, and no second one.
inline void search_from(searches_t *searches, vec v, start_t start, int stays, integer anew) {
  searches->v = vec_select(searches->v, v, anew);
  searches->slope = select(searches->slope, start.slope, anew);
  begin(&searches->search, start.x, (integer)(0), anew);
  searches->second &= !anew;
  searches->last = select(searches->last, (integer)(stays ? -1 : 0), anew);
}

// Evaluates the map once for searches that are `going`; those that end have their fit then. If one
// fails, and a second one, too, the better of them goes on to its end.
inline integer ends_here(const map_t *map, searches_t *searches, fit_t *fit, integer going) {
  const cuts_t *cuts = &map->cuts;
  search_t *search = &searches->search;
  const integer none = 0, begins = (search->rounds == 0) & !searches->second;
  look(cuts, &fit->view, searches->v, search->x);
  fit->view.passed = search->passed;
  fit_view(map, fit);
  vec y = origin_of(cuts, searches->v, moved(map, fit));
  integer ended = is_settled(search, y) | (search->rounds >= ROUNDS - 1);
  const start_t start = {search->x, searches->slope};
  ended |= begins & is_foreseen(&start, y);
  integer clear = begins & !ended & !fit->view.hides;
  if (ANY(going & clear)) {  // then perhaps nothing is hidden in the end
    view_t view;
    look(cuts, &view, searches->v, y);
    ended |= clear & !hides(map, &view);
  }
  integer retries = none, returns = none, behind = going & !searches->last & (search->passed != 0);
  if (ANY(behind)) {
    real depth = -void_distance_of(cuts, y, y, search->passed);
    behind &= ended | is_lost(search, y, depth);
    retries = behind & !searches->second;
    searches->last |= behind & searches->second;
    returns = behind & searches->second & (searches->first_depth < depth);
    searches->first_depth = select(searches->first_depth, depth, retries);
  }
  going &= !(ended | retries | returns);
  if (ANY(going)) advance(cuts, search, y, going);
  search->rounds += 1;
  if (ANY(retries | returns)) {
    begin(search, searches->first, searches->first_passed, returns);
    searches->first = vec_select(searches->first, y, retries);
    searches->first_passed = select(searches->first_passed, search->passed, retries);
    begin(search, y, none, retries);
    searches->second |= retries;
  }
  return ended & !(retries | returns);
}

// The fit at v, for the place that searches from `start` find.
inline fit_t fit_from(const map_t *map, vec v, start_t start) {
  integer going = (real)(0) == 0;
  searches_t searches = {v};
  search_from(&searches, v, start, 0, going);
  fit_t fit;
  while (ANY(going)) going &= !ends_here(map, &searches, &fit, going);
  return fit;
}

inline fit_t fit_at(const map_t *map, vec v) {
  return fit_from(map, v, affine_start(map, v));
}

// d(G - v)/dv from both parts of it: the place x from which cuts are seen moves, too.
inline mat with_moving_origin(const fit_t *fit, const weight_jacobian_t *jacobian) {
  integer still = fit->pivot.d2 >= UNREACHABLE;
  mat by_v = still_if(jacobian->by_v, still), by_x = still_if(jacobian->by_x, still), by_x_less;
  for (int i = 0; i < 9; ++i) by_x_less.a[i] = -by_x.a[i];
  for (int column = 0; column < 3; ++column) {
    vec right = {by_v.a[column] + by_x.a[column], by_v.a[3 + column] + by_x.a[3 + column],
                 by_v.a[6 + column] + by_x.a[6 + column]};
    vec d = identity_solve(&by_x_less, right);
    by_v.a[column] = d.x;
    by_v.a[3 + column] = d.y;
    by_v.a[6 + column] = d.z;
  }
  return by_v;
}

inline mat moved_jacobian(const map_t *map, const fit_t *fit) {
  weight_jacobian_t jacobian = displacement_jacobian(map, fit);
  return with_moving_origin(fit, &jacobian);
}
