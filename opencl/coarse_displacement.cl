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
  // read here: with an index in a loop rusticl's llvmpipe reads another one
  const float scale_to_world = world.scale;
  const float mean_displacement[3] = {world.mean_displacement[0], world.mean_displacement[1],
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
      points_t points;
      if (!points_of(&points, &grid, &strip, j, k)) continue;
      if (!is_there) layer_between(&layer, &coarse, nodes, &strip, k);
      is_there = 1;
      real d[COARSE_STEP][3];
      for (int i = 0; i < COARSE_STEP; ++i)
        for (int p = 0; p < 3; ++p)
          d[i][p] = fma((real)(scale_to_world), points_between(&layer, p, i, j),
                        (real)(mean_displacement[p]));
      __global float *to = displacement + 3 * points.at;
      int whole = points.low == 0 && points.high == LANES * COARSE_STEP;
#if CUTS
      integer kept[COARSE_STEP];
      real distance[COARSE_STEP];
      for (int i = 0; i < COARSE_STEP; ++i) {
        vec index = points.index;
        index.x += i;
        kept[i] = in_region(&map.cuts, index);
        distance[i] = scale * points_between(&layer, 3, i, j);
        whole &= ALL(kept[i]);
      }
#endif
      if (whole) {
        for (int l = 0; l < LANES; ++l)
          for (int i = 0; i < COARSE_STEP; ++i)
            for (int p = 0; p < 3; ++p)
              to[3 * (COARSE_STEP * l + i) + p] = LANE(d[i][p], l);
#if CUTS
        for (int l = 0; l < LANES; ++l)
          for (int i = 0; i < COARSE_STEP; ++i)
            void_distance[points.at + COARSE_STEP * l + i] = LANE(distance[i], l);
#endif
        continue;
      }
      for (int n = points.low; n < points.high; ++n) {
        const int i = n % COARSE_STEP, l = n / COARSE_STEP;
#if CUTS
        if (!LANE_INT(kept[i], l)) continue;
        void_distance[points.at + n] = LANE(distance[i], l);
#endif
        for (int p = 0; p < 3; ++p) to[3 * n + p] = LANE(d[i][p], l);
      }
    }
  }
}
