#include "source_index.cl"

// What grid_source_index writes, interpolated between nodes.
KERNEL void coarse_source_index(MAP_PARAMETERS, const grid_t grid, const coarse_t coarse,
                                __global const float *restrict nodes, const source_t source,
                                __global float *restrict index
#if CUTS
                                VOID_PARAMETERS
#endif
) {
#if CUTS
  const map_t map = MAP;
#endif
  strip_t strip;
  if (!strip_of(&coarse, &strip)) return;
#if CUTS
  if (!ANY(in_reach(&map.cuts, corners_of(&strip)))) return;
#endif
  const long count = grid.stop - grid.first;
  for (int k = 0; k < COARSE_STEP; ++k) {
    layer_t layer;
    int is_there = 0;
    for (int j = 0; j < COARSE_STEP; ++j) {
      points_t points;
      if (!points_of(&points, &grid, &strip, j, k)) continue;
      if (!is_there) layer_between(&layer, &coarse, nodes, &strip, k);
      is_there = 1;
      vec from[COARSE_STEP];
      int whole = points.low == 0 && points.high == LANES * COARSE_STEP;
#if CUTS
      integer kept[COARSE_STEP];
#endif
      for (int i = 0; i < COARSE_STEP; ++i) {
        vec d = {points_between(&layer, 0, i, j), points_between(&layer, 1, i, j),
                 points_between(&layer, 2, i, j)};
        vec at = points.index;
        at.x += i;
        from[i] = source_index_of(&source, at, d);
#if CUTS
        real distance = points_between(&layer, 3, i, j);
        if (!source.continued) from[i] = outside_if(from[i], distance < 0);
        kept[i] = in_region(&map.cuts, at);
        whole &= ALL(kept[i]);
        if (void_distance)
          for (int l = 0; l < LANES; ++l) {
            int n = l * COARSE_STEP + i;
            if (n >= points.low && n < points.high && LANE_INT(kept[i], l))
              void_distance[points.at + n] = scale * LANE(distance, l);
          }
#endif
      }
      __global float *to = index + points.at;
      if (whole) {
        for (int l = 0; l < LANES; ++l)
          for (int i = 0; i < COARSE_STEP; ++i) {
            int n = COARSE_STEP * l + i;
            to[n] = LANE(from[i].x, l);
            to[count + n] = LANE(from[i].y, l);
            to[2 * count + n] = LANE(from[i].z, l);
          }
        continue;
      }
      for (int n = points.low; n < points.high; ++n) {
        const int i = n % COARSE_STEP, l = n / COARSE_STEP;
#if CUTS
        if (!LANE_INT(kept[i], l)) continue;
#endif
        to[n] = LANE(from[i].x, l);
        to[count + n] = LANE(from[i].y, l);
        to[2 * count + n] = LANE(from[i].z, l);
      }
    }
  }
}
