#include "on_grid.cl"

// G(v) - v, world units, interleaved, for the points `first` to `stop` of a grid; with cuts also the
// void distance (cuts.cl), world units.
KERNEL void grid_displacement(MAP_PARAMETERS, const grid_t grid, const world_t world,
                              __global float *restrict displacement
#if CUTS
                              , __global float *restrict void_distance
#endif
) {
  const map_t map = MAP;
  const item_t item = item_of(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_at(&map, transformed(grid.frame, item.index));
  vec d = moved(&map, &fit);
#if CUTS
  real nothing = void_distance_at(&map, &fit, d);
#endif
  for (int l = 0; l < item.lanes; ++l)
    if (is_kept(&item, l)) {
      __global float *to = displacement + 3 * (item.at + l);
      to[0] = fma(world.scale, LANE(d.x, l), world.mean_displacement[0]);
      to[1] = fma(world.scale, LANE(d.y, l), world.mean_displacement[1]);
      to[2] = fma(world.scale, LANE(d.z, l), world.mean_displacement[2]);
#if CUTS
      void_distance[item.at + l] = world.scale * LANE(nothing, l);
#endif
    }
}
