// The backward map at a point.

#include "types.cl"
#include "powers.cl"
#if CUTS
#include "cuts.cl"
#endif
#include "weights.cl"
#include FIT

// G(v) - v - mean displacement; 0 displacement where no control point can be reached.
inline vec map_displacement(const map_t *map, const fit_t *fit) {
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

// d(G - v)/dv of the material at v, at a fixed origin.
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
  set_point_at(map, &fit.point, v);
  fit_map(map, &fit);
  return fit;
}

inline mat map_jacobian(const map_t *map, const fit_t *fit) {
  return material_jacobian(map, fit);
}
#endif

#if CUTS
// The void distance for the displacement d of the map, local units.
inline real void_distance_at(const map_t *map, const fit_t *fit, vec d) {
  vec g = origin_of(&map->cuts, fit->point.v, d);
#if AT_REST
  return void_distance_of(&map->cuts, g, g, fit->point.crossed_cuts);
#else
  return void_distance_of(&map->cuts, fit->point.v, g, (integer)(0));
#endif
}
#endif
