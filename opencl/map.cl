// The backward map at a point. Build constants: README.md.

#include "types.cl"
#include "powers.cl"
#if CUTS
#include "cuts.cl"
#endif
#include "weights.cl"
#include FIT

#ifndef WORLD
#error "WORLD is missing: members of the struct below"
#endif

// Displacements in the world: `scale` times the local ones and the `mean_displacement`.
typedef struct { WORLD } world_t;

// G(v) - v - mean displacement; where no control point can be reached, nothing moves.
inline vec moved(const map_t *map, const fit_t *fit) {
  vec d = displacement_of(map, fit);
#if CUTS
  vec still = vec_scale((real)(-1), mean_displacement_of(&map->cuts));
  d = vec_select(d, still, fit->pivot.d2 >= UNREACHABLE);
#endif
  return d;
}

// d(G - v)/dv likewise.
inline mat moved_jacobian(const map_t *map, const fit_t *fit) {
  mat j = displacement_jacobian(map, fit);
#if CUTS
  for (int i = 0; i < 9; ++i) j.a[i] = select(j.a[i], (real)(0), fit->pivot.d2 >= UNREACHABLE);
#endif
  return j;
}
