#include "map.cl"

// G(v) - v - mean displacement in three planes, local frame.
KERNEL void point_displacement(MAP_PARAMETERS, const long points_count,
                               __global const float *restrict points,
                               __global float *restrict displacement) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  fit_t fit = fit_at(&map, load_points(points, points_count, first));
  store_points(displacement, moved(&map, &fit), points_count, first);
}
