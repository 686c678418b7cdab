#include "map.cl"

// As point_displacement, for the material on the side of the cuts where `starts` are, which the map
// continues behind the faces; only with cuts in the rest frame.
KERNEL void point_search(MAP_PARAMETERS, const long points_count,
                         __global const float *restrict points,
                         __global const float *restrict starts,
                         __global float *restrict displacement) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec v = load_points(points, points_count, first);
  start_t start = {load_points(starts, points_count, first), UNKNOWN_SLOPE};
  fit_t fit = fit_from(&map, v, start, 1);
  vec d = moved(&map, &fit);
  store_points(displacement, d, points_count, first);
  real nothing = void_distance_at(&map, &fit, d);
  store_plane(displacement + 3 * points_count, nothing, points_count, first);
}
