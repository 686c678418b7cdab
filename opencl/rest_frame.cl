// Cuts that belong to the material: which control points act on it is decided in the undeformed
// space. A cut sees the control point i at p_i, and the material at its own place x. So the map is
// the fixed point x = G(v; damping as seen from x).
//
// The search for x begins where the affine map that fits all control points best has it. A step that
// passes a cut goes on as if the cut were still ahead (bit i of `passed`): what blocks is exchanged,
// and the map continued smoothly behind the face. If it ends there, the material on that side of the
// cut does not reach v; the other side gets a search of its own, from that place. If that ends behind
// the cut too, v is void.

#define ROUNDS 12       // of one search
#define SETTLED 3e-7f   // next to the size of x: a residual that ends it, ...
#define FORESEEN 3e-8f  // ... and what two residuals say of the error that is left

// Whether a cut hides any of the control points from view->seen.
inline integer hides(const map_t *map, const view_t *view) {
  integer hidden = 0;
  for (int i = 0; i < map->numbers.count; ++i)
    hidden |= is_hidden(&map->cuts, view, i, seen_point(map, map->control_points + i));
  return hidden;
}

// Where the affine map has the material that is at v.
inline vec first_guess(const cuts_t *cuts, vec v) {
  return transformed(cuts->numbers.affine, v);
}

// A search for x: where it is, from behind which cuts it sees, its last residual and where that led.
typedef struct {
  vec x, residual, led;
  integer passed;
  integer stepped;  // whether there is a last residual
} search_t;

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

// The fit at v, for the place that a search from `start` finds; if that ends behind a cut, a second
// of the `searches` begins there.
inline fit_t fit_from(const map_t *map, vec v, vec start, int searches) {
  const cuts_t *cuts = &map->cuts;
  fit_t fit;
  search_t search;
  search.x = start;
  search.residual = search.led = v;
  search.passed = search.stepped = (integer)(0);
  vec first = v;  // where the first search ended
  integer first_passed = 0, going = (real)(0) == 0, again = 0, rounds = 0;
  for (int i = 0; i <= 2 * ROUNDS; ++i) {
    look(cuts, &fit.view, v, search.x);
    fit.view.passed = search.passed;
    fit_view(map, &fit);
    vec y = origin_of(cuts, v, moved(map, &fit)), residual = vec_sub(y, search.x);
    if (i == 0 && !ANY(fit.view.hides)) {  // then perhaps nothing is hidden in the end
      look(cuts, &fit.view, v, y);
      if (!ANY(hides(map, &fit.view))) break;
    }
    real left2 = dot3(residual, residual), before2 = dot3(search.residual, search.residual);
    real size = size_of(y), foreseen = FORESEEN * size;
    integer settled = (left2 <= SETTLED * SETTLED * size * size) |
                      (search.stepped & (left2 * left2 <= foreseen * foreseen * before2));
    integer ended = going & (settled | (rounds >= ROUNDS - 1));
    integer behind = ended & (search.passed != 0), stale = 0;
    going &= !ended;
    rounds += 1;
    if (ANY(going)) advance(cuts, &search, y, going);
    if (ANY(behind)) {
      integer fails = behind & again, retries = behind & !again & (integer)(searches > 1 ? -1 : 0);
      if (ANY(fails)) {
        stale = fails & (void_distance_of(cuts, first, first, first_passed) >
                         void_distance_of(cuts, search.x, search.x, search.passed));
        search.x = vec_select(search.x, first, stale);
        search.passed = select(search.passed, first_passed, stale);
      }
      first = vec_select(first, search.x, retries);
      first_passed = select(first_passed, search.passed, retries);
      search.passed = select(search.passed, (integer)(0), retries);
      search.stepped &= !retries;
      rounds = select(rounds, (integer)(0), retries);
      again |= retries;
      going |= retries;
    }
    if (!ANY(going | stale)) break;
  }
  return fit;
}

inline fit_t fit_at(const map_t *map, vec v) {
  return fit_from(map, v, first_guess(&map->cuts, v), 2);
}

// d(G - v)/dv: the place x from which cuts are seen moves, too.
inline mat moved_jacobian(const map_t *map, const fit_t *fit) {
  weight_jacobian_t jacobian = displacement_jacobian(map, fit);
  integer still = fit->pivot.d2 >= UNREACHABLE;
  mat by_v = still_if(jacobian.by_v, still), by_x = still_if(jacobian.by_x, still), by_x_less;
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
