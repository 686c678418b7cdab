// The backward map at a point. Build constants: README.md.

#include "types.cl"
#include "powers.cl"
#if CUTS
#include "cuts.cl"
#endif
#include "weights.cl"
#include FIT

// G(v) - v - mean displacement; where no control point can be reached, nothing moves.
inline vec moved(const map_t *map, const fit_t *fit) {
  vec d = displacement_of(map, fit);
#if CUTS
  vec still = vec_scale((real)(-1), mean_displacement_of(&map->cuts));
  d = vec_select(d, still, fit->pivot.d2 >= UNREACHABLE);
#endif
  return d;
}

inline mat still_if(mat j, integer still) {
  for (int i = 0; i < 9; ++i) j.a[i] = select(j.a[i], (real)(0), still);
  return j;
}

// d(G - v)/dv likewise, for the material that is there.
inline mat material_jacobian(const map_t *map, const fit_t *fit) {
  mat j = displacement_jacobian(map, fit).by_v;
#if CUTS
  j = still_if(j, fit->pivot.d2 >= UNREACHABLE);
#endif
  return j;
}

#if AT_REST
#include "rest_frame.cl"
#else
inline fit_t fit_at(const map_t *map, vec v) {
  fit_t fit;
  look_at(map, &fit.view, v);
  fit_view(map, &fit);
  return fit;
}

inline mat moved_jacobian(const map_t *map, const fit_t *fit) {
  return material_jacobian(map, fit);
}
#endif

#if CUTS
// The void distance for the displacement d of the map, local units.
inline real void_distance_at(const map_t *map, const fit_t *fit, vec d) {
  vec g = origin_of(&map->cuts, fit->view.v, d);
#if AT_REST
  return void_distance_of(&map->cuts, g, g, fit->view.passed);
#else
  return void_distance_of(&map->cuts, fit->view.v, g, (integer)(0));
#endif
}
#endif
