#include "on_grid.cl"

// G(v) - v, world units, interleaved, for the points `first` to `stop` of a grid; with cuts also the
// void distance (cuts.cl), world units.
KERNEL void grid_displacement(MAP_PARAMETERS, GRID_PARAMETERS, const float scale,
                              const float4 mean_displacement, __global float *restrict displacement
#if CUTS
                              , __global float *restrict void_distance
#endif
) {
  FIT_ON_GRID
  vec d = moved(&map, &fit);
#if CUTS
  real nothing = void_distance_of(&map.cuts, fit.view.v, origin_of(&map.cuts, fit.view.v, d));
#endif
  for (int l = 0; l < lanes; ++l)
    if (KEPT(l)) {
      __global float *to = displacement + 3 * (at + l);
      to[0] = fma(scale, LANE(d.x, l), mean_displacement.x);
      to[1] = fma(scale, LANE(d.y, l), mean_displacement.y);
      to[2] = fma(scale, LANE(d.z, l), mean_displacement.z);
#if CUTS
      void_distance[at + l] = scale * LANE(nothing, l);
#endif
    }
}
