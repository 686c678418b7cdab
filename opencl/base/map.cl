// The backward map at a point: one step, or several. The last step comes first: it leads from the
// deformed space to the previous stage.
//
// Build constants: those of the files, which the host names: CUT_FILE, REGION_FILE, SEGMENT_FILE,
// LIMIT_FILE, STEP_FILE and FRAME_FILE are files of a feature or of its absence, FIT is that of a kind.

#include "types.cl"
#include "powers.cl"
#include CUT_FILE
#include "weights.cl"
#include "terms.cl"
#include FIT
#include LIMIT_FILE

// G(v) - v - mean displacement of a step, before limits; 0 displacement where no control point can be
// reached.
inline vec unlimited_displacement(const map_t *map, const fit_t *fit) {
  vec d = displacement_of(map, fit);
  if (SEGMENTS)  // on a curve itself, where sums of a high degree lose what is off the curve
    d = vec_select(d, fit->pivot.u,
                   (fit->pivot.k >= map->params.count) & (fit->pivot.d2 <= ON_CURVE * ON_CURVE));
  if (CUTS) {
    const vec rest = vec_scale((real)(-1), mean_displacement_of(&map->cuts));
    d = vec_select(d, rest, is_unreachable(fit->pivot.d2));
  }
  return d;
}

// G(v) - v - mean displacement of a step, which is 0 where there are limits.
inline vec step_displacement(const map_t *map, const fit_t *fit) {
  return limited(map, fit->point.v, unlimited_displacement(map, fit));
}

inline mat zero_if(mat j, integer condition) {
  for (int i = 0; i < 9; ++i) j.a[i] = select(j.a[i], (real)(0), condition);
  return j;
}

// d(G - v)/dv of a step at a fixed origin, and in the rest frame by the origin.
inline weight_jacobian_t step_jacobian(const map_t *map, const fit_t *fit) {
  weight_jacobian_t jacobian = displacement_jacobian(map, fit);
  if (CUTS) {
    const integer is_cut_off = is_unreachable(fit->pivot.d2);
    jacobian.d_dv = zero_if(jacobian.d_dv, is_cut_off);
    if (AT_REST) jacobian.d_dx = zero_if(jacobian.d_dx, is_cut_off);
  }
  if (!LIMITS) return jacobian;
  return limited_jacobian(map, fit->point.v, unlimited_displacement(map, fit), jacobian);
}

// det(I + a).
inline real determinant_of(const mat *a) {
  const vec x = {1 + a->a[0], a->a[1], a->a[2]}, y = {a->a[3], 1 + a->a[4], a->a[5]},
            z = {a->a[6], a->a[7], 1 + a->a[8]};
  return dot3(x, cross3(y, z));
}

#include STEP_FILE

// d(G - v)/dv at a fixed origin, and in the rest frame by the origin.
inline weight_jacobian_t map_weight_jacobian(const map_t *map, const fit_t *fit) {
  real least_determinant;
  return composed_jacobian(map, fit, &least_determinant);
}

// d(G - v)/dv of the material at v, at a fixed origin.
inline mat material_jacobian(const map_t *map, const fit_t *fit) {
  return map_weight_jacobian(map, fit).d_dv;
}

// The void distance for the displacement d of the map, local units.
inline real void_distance_at(const map_t *map, const fit_t *fit, vec d) {
  const vec g = origin_of(&map->cuts, start_of(fit), d);
  if (AT_REST) return void_distance_of(&map->cuts, g, g, fit->point.view.crossed_cuts);
  const real distance = void_distance_of(&map->cuts, fit->point.v, g, (integer)(0));
  return STEPS ? fast_min(fit->point.steps.void_distance, distance) : distance;
}

#include FRAME_FILE

// J^T n for J = dG/dv at a fixed origin.
inline vec transposed_jacobian_vec(const map_t *map, const fit_t *fit, vec n) {
#if HAS_TRANSPOSED_JACOBIAN
  if (is_transposed_jacobian_exact(map, fit))
    return vec_add(n, transposed_displacement_jacobian(map, fit, n));
#endif
  const mat j = map_jacobian(map, fit);
  return vec_add(n, transposed_mat_vec(&j, n));
}
