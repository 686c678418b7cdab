// The inverse of the backward map: for points x the displacement v - x to v with G(v) = x.
//
// All x are local, less the mean displacement. The displacement d(v) = G(v) - v of the map is small
// relative to v: the solver finds s with s + d(x + s) = 0, and v - x loses no digits.

#define INVERSE 1  // for digit_loss.cl
#include "map.cl"
#include "lattice.cl"

#define MAX_TRIALS (STEPS ? 64 : 32)
#define MIN_SHARE 0.03f
#define STEP_SHARE 1e-3f         // of several, which do not fold: short enough Newton steps lead to v
#define POLISHED_FROM 1e-5f      // largest residual of a step after which only rounding keeps ...
#define POLISHING_SHARE 0.5f     // ... whole steps from reducing the residual of all steps
#define MIN_DECREASE 0.1f        // of the residual, relative to the predicted decrease
#define INVERSE_TOLERANCE 3e-7f  // relative to x: about the resolution of float32
#define STEPS_TOLERANCE 6e-8f    // the same for all steps together, where material is squeezed
#define MAX_CHORDS 5
#define CHORD_TOLERANCE 5e-6f    // before the last step, which is not checked

inline real length3(vec a) { return sqrt(dot3(a, a)); }

// x - G(x + displacement), and the fit there. In the rest frame cuts see from `rest`.
inline vec residual(const map_t *map, vec x, vec rest, vec displacement, fit_t *fit) {
  const vec v = vec_add(x, displacement);
  set_point(&map->cuts, &fit->point, v,
            AT_REST ? origin_of(&map->cuts, rest, (vec){0, 0, 0}) : v);
  fit_map(map, fit);
  return vec_scale((real)(-1), vec_add(displacement, map_displacement(map, fit)));
}

// Whether an obstacle separates x from its image. Only for cuts that stay: in the rest frame the origin
// x is on its side of the cuts.
inline integer is_blocked(const map_t *map, vec x, vec displacement) {
  if (!CUTS || AT_REST || regions_compete(&map->cuts)) return 0;
  return blocked(&map->cuts, origin_of(&map->cuts, x, (vec){0, 0, 0}), vec_add(x, displacement));
}

// The same for any cut.
inline integer is_cut_off(const map_t *map, vec x, vec displacement) {
  if (!CUTS || AT_REST || regions_compete(&map->cuts)) return 0;
  return is_blocked(map, x, displacement) |
         !on_side(&map->cuts, vec_add(x, displacement), size_of(x));
}

// Newton's method from a first guess in `displacement`; returns the residual relative to the size of x.
// A step that reduces the residual too little is halved, and the next one is at most twice as long, so
// that searches without a solution end soon. A search may cross cuts; is_cut_off checks its end. Lanes
// that have ended do not change.
inline real newton(const map_t *map, vec x, vec rest, float tolerance, real min_share,
                   vec *displacement) {
  real smallest = FLT_MAX, share = 1, close = tolerance * size_of(x);
  vec step = {0, 0, 0}, trial = *displacement;
  integer open = (real)(0) == 0;
  for (int i = 0; i < MAX_TRIALS; ++i) {
    fit_t fit;
    vec r = residual(map, x, rest, trial, &fit);
    real distance = length3(r);
    integer better = open & (distance < smallest * fma(-MIN_DECREASE, share, (real)(1)));
    *displacement = vec_select(*displacement, trial, better);
    smallest = select(smallest, distance, better);
    share = select(share * 0.5f, fast_min(2 * share, (real)(1)), better);
    open &= (smallest > close) & (share > min_share);
    if (!ANY(open)) break;
    if (ANY(open & better)) {
      mat jacobian = material_jacobian(map, &fit);
      step = vec_select(step, identity_solve(&jacobian, r), better);
    }
    trial = vec_madd(share, step, *displacement);
  }
  return smallest / size_of(x);
}

// The steps one after the other, each from no displacement, then together for what rounding has left.
// Returns the residual of all steps together or the largest of one step, whichever is smaller: where
// steps expand, rounding of a stage is more than any tolerance in the residual of all.
inline real newton_by_steps(const map_t *map, vec x, vec *displacement) {
  integer cut_off = 0;
  real largest = 0;
  *displacement = (vec){0, 0, 0};
  for (int k = 0; k < map->params.step_count; ++k) {
    const map_t step = step_of(map, k);
    const vec stage = vec_add(x, *displacement);
    vec d = {0, 0, 0};
    largest = fast_max(newton(&step, stage, x, INVERSE_TOLERANCE, (real)(STEP_SHARE), &d), largest);
    cut_off |= is_cut_off(&step, stage, d);
    *displacement = vec_add(*displacement, d);
  }
  const real min_share =
      select((real)(MIN_SHARE), (real)(POLISHING_SHARE), largest <= POLISHED_FROM);
  const real of_all = newton(map, x, x, STEPS_TOLERANCE, min_share, displacement);
  return select(fast_min(of_all, largest), (real)(FLT_MAX), cut_off);
}

// Broyden's method from first guesses of `displacement` and of dv/dx in `response`: no Jacobians, no
// step control. Returns the residual relative to the size of x, before the last step.
inline real broyden(const map_t *map, vec x, vec *displacement, mat *response) {
  real smallest = FLT_MAX, close = CHORD_TOLERANCE * size_of(x);
  vec step = {0, 0, 0};
  for (int i = 0; i < MAX_CHORDS; ++i) {
    fit_t fit;
    integer open = smallest > close;
    vec r = residual(map, x, x, *displacement, &fit);
    smallest = select(smallest, length3(r), open);
    // the response to the last step was step - t instead of the predicted `step`
    vec t = mat_vec(response, r);
    real square = dot3(step, step), change = dot3(step, t);
    real gain = 1 / fast_max(square - change, fma((real)(0.2f), square, (real)(1e-30f)));
    add_outer(response, vec_scale(gain, t), transposed_mat_vec(response, step));
    step = vec_scale(fma(change, gain, (real)(1)), t);
    *displacement = vec_select(*displacement, vec_add(*displacement, step), open);
    if (!ANY(smallest > close)) break;
  }
  return smallest / size_of(x);
}

// The displacement at x, trilinear in the displacements at the lattice nodes, and dv/dx. Returns whether
// x is in a cell. Nodes are numbered like cells.
inline integer guess_at(const lattice_t *lattice, __global const float4 *nodes, vec x,
                        vec *displacement, mat *response) {
  vec share;
  real shrink;
  integer node_index;
  integer inside = lattice_cell(lattice, x, &share, &shrink, &node_index) < LATTICE_SIZE;
  for (int l = 0; l < LANES; ++l) {
    __global const float4 *node = nodes + (LANE_INT(inside, l) ? LANE_INT(node_index, l) : 0);
    const trilinear_t at =
        trilinear((__global const float *)node, NODES_ALONG, NODES_ALONG * NODES_ALONG,
                  LANE(share.x, l), LANE(share.y, l), LANE(share.z, l));
    const float density = 0.5f * LATTICE_CELLS * LANE(shrink, l);
    const float4 x = density * lattice->density[0] * at.by_x,
                 y = density * lattice->density[1] * at.by_y,
                 z = density * lattice->density[2] * at.by_z;
    set_lane(displacement, l, at.value.xyz);
    set_mat_lane(response, l, x.xyz, y.xyz, z.xyz);
  }
  UNROLL_ALL for (int i = 0; i < 9; i += 4) response->a[i] += 1;
  return inside;
}
