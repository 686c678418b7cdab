#include "on_grid.cl"

// What grid_displacement writes, interpolated between nodes.
KERNEL void coarse_displacement(MAP_PARAMETERS, const grid_t grid, const coarse_t coarse,
                                __global const float *restrict nodes, const world_t world,
                                __global float *restrict displacement
#if CUTS
                                VOID_PARAMETERS
#endif
) {
#if CUTS
  const map_t map = MAP;
#endif
  const real scale_to_world = world.scale;
  const vec mean = {world.mean_displacement[0], world.mean_displacement[1],
                    world.mean_displacement[2]};
  strip_t strip;
  if (!strip_of(&coarse, &strip)) return;
#if CUTS
  if (!ANY(in_reach(&map.cuts, corners_of(&strip)))) return;
#endif
  for (int k = 0; k < COARSE_STEP; ++k) {
    layer_t layer;
    int is_there = 0;
    for (int j = 0; j < COARSE_STEP; ++j) {
      row_t row;
      if (!row_of_strip(&row, &grid, &strip, j, k)) continue;
      if (!is_there) layer_between(&layer, &coarse, nodes, &strip, k, NO_SLOPE);
      is_there = 1;
      real found[PLANES][COARSE_STEP];
      for (int p = 0; p < PLANES; ++p) row_between(found[p], &layer, p, j, 0);
      for (int n = 0; n < COARSE_STEP; ++n) {
        integer kept = are_in_launch(&row, n);
#if CUTS
        kept &= in_region(&map.cuts, indices_in(&row, n));
        store_in_row(void_distance, scale * found[3][n], &row, n, kept);
#endif
        const vec d = vec_madd(scale_to_world, (vec){found[0][n], found[1][n], found[2][n]}, mean);
        __global float *to = displacement + 3 * (row.at + n * LANES);
        if (ALL(kept)) {
          store_interleaved(to, d, LANES);
          continue;
        }
        for (int l = 0; l < LANES; ++l)
          if (LANE_INT(kept, l)) store_point(to + 3 * l, d, l);
      }
    }
  }
}
