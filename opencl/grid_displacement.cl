#include "on_grid.cl"

// G(v) - v, world units, interleaved, for the points `first` to `stop` of a grid; with cuts also the
// opening (cuts.cl), world units.
KERNEL void grid_displacement(MAP_PARAMETERS, LATTICE_PARAMETERS, const float scale,
                              const float4 drift, __global float *restrict displacement
#if CUTS
                              , __global float *restrict opening
#endif
) {
  FIT_ON_GRID
  vec d = moved(&map, &fit);
#if CUTS
  real open = opening_of(&map.cuts, fit.view.v, origin_of(&map.cuts, fit.view.v, d));
#endif
  for (int l = 0; l < lanes; ++l)
    if (KEPT(l)) {
      __global float *to = displacement + 3 * (at + l);
      to[0] = fma(scale, LANE(d.x, l), drift.x);
      to[1] = fma(scale, LANE(d.y, l), drift.y);
      to[2] = fma(scale, LANE(d.z, l), drift.z);
#if CUTS
      opening[at + l] = scale * LANE(open, l);
#endif
    }
}
