#include "map.cl"
#include "clusters.cl"

#ifndef POINTS_PER_LIST
#error "POINTS_PER_LIST is missing: how many points one behind the other have a list of their own"
#endif

// What point_displacement writes, where each POINTS_PER_LIST points have a list.
KERNEL void clustered_displacement(MAP_PARAMETERS LIST_PARAMETERS, const long points_count,
                                   __global const float *restrict points,
                                   __global float *restrict displacement) {
  const long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  map_t map = MAP;
  take_list(&map, LISTS_OF_LAUNCH, first / POINTS_PER_LIST, (points_count - 1) / POINTS_PER_LIST + 1);
  const fit_t fit = fit_at(&map, load_points(points, points_count, first));
  store_points(displacement, moved(&map, &fit), points_count, first);
}
