// The backward map at a point: one step, or several. The last step comes first: it leads from the
// deformed space to the previous stage.

#include "types.cl"
#include "powers.cl"
#if CUTS
#include "cuts.cl"
#endif
#include "weights.cl"
#include "terms.cl"
#include FIT
#if LIMITS
#include "limits.cl"
#endif

// G(v) - v - mean displacement of a step, before limits; 0 displacement where no control point can be
// reached.
inline vec unlimited_displacement(const map_t *map, const fit_t *fit) {
  vec d = displacement_of(map, fit);
#if SEGMENTS
  // on a curve itself, where sums of a high degree lose what is off the curve
  d = vec_select(d, fit->pivot.u,
                 (fit->pivot.k >= map->params.count) & (fit->pivot.d2 <= ON_CURVE * ON_CURVE));
#endif
#if CUTS
  vec rest = vec_scale((real)(-1), mean_displacement_of(&map->cuts));
  d = vec_select(d, rest, fit->pivot.d2 >= UNREACHABLE);
#endif
  return d;
}

// G(v) - v - mean displacement of a step, which is 0 where there are limits.
inline vec step_displacement(const map_t *map, const fit_t *fit) {
#if LIMITS
  return limited(map, fit->point.v, unlimited_displacement(map, fit));
#else
  return unlimited_displacement(map, fit);
#endif
}

inline mat zero_if(mat j, integer condition) {
  for (int i = 0; i < 9; ++i) j.a[i] = select(j.a[i], (real)(0), condition);
  return j;
}

// d(G - v)/dv of a step at a fixed origin, and in the rest frame by the origin.
inline weight_jacobian_t step_jacobian(const map_t *map, const fit_t *fit) {
  weight_jacobian_t jacobian = displacement_jacobian(map, fit);
#if CUTS
  integer is_unreachable = fit->pivot.d2 >= UNREACHABLE;
  jacobian.by_v = zero_if(jacobian.by_v, is_unreachable);
#if AT_REST
  jacobian.by_x = zero_if(jacobian.by_x, is_unreachable);
#endif
#endif
#if LIMITS
  jacobian = limited_jacobian(map, fit->point.v, unlimited_displacement(map, fit), jacobian);
#endif
  return jacobian;
}

#if STEPS
#include "steps.cl"
#else
inline void fit_map(const map_t *map, fit_t *fit) { fit_step(map, fit); }

inline vec start_of(const fit_t *fit) { return fit->point.v; }

// G(v) - v - mean displacement.
inline vec map_displacement(const map_t *map, const fit_t *fit) {
  return step_displacement(map, fit);
}

// d(G - v)/dv at a fixed origin, and in the rest frame by the origin.
inline weight_jacobian_t map_weight_jacobian(const map_t *map, const fit_t *fit) {
  return step_jacobian(map, fit);
}
#endif

// d(G - v)/dv of the material at v, at a fixed origin.
inline mat material_jacobian(const map_t *map, const fit_t *fit) {
  return map_weight_jacobian(map, fit).by_v;
}

#if AT_REST
#include "rest_frame.cl"
#else
inline fit_t fit_at(const map_t *map, vec v) {
  fit_t fit;
  set_point_at(map, &fit.point, v);
  fit_map(map, &fit);
  return fit;
}

inline mat map_jacobian(const map_t *map, const fit_t *fit) {
  return material_jacobian(map, fit);
}
#endif

// J^T n for J = dG/dv at a fixed origin.
inline vec transposed_jacobian_vec(const map_t *map, const fit_t *fit, vec n) {
#if HAS_TRANSPOSED_JACOBIAN
  if (is_transposed_jacobian_exact(map, fit))
    return vec_add(n, transposed_displacement_jacobian(map, fit, n));
#endif
  const mat j = map_jacobian(map, fit);
  return vec_add(n, transposed_mat_vec(&j, n));
}

#if CUTS
// The void distance for the displacement d of the map, local units.
inline real void_distance_at(const map_t *map, const fit_t *fit, vec d) {
  vec g = origin_of(&map->cuts, start_of(fit), d);
#if AT_REST
  return void_distance_of(&map->cuts, g, g, fit->point.crossed_cuts);
#elif STEPS
  return fast_min(fit->point.steps.void_distance,
               void_distance_of(&map->cuts, fit->point.v, g, (integer)(0)));
#else
  return void_distance_of(&map->cuts, fit->point.v, g, (integer)(0));
#endif
}
#endif
