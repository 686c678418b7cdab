#include "map.cl"

// d(G - v)/dv in nine planes, for material with given `origins`, from which cuts see; only with cuts in
// the rest frame.
__kernel EXPLICIT_VECTORS void origin_jacobian(
    MAP_ARGUMENTS, POINT_ARGUMENTS, __global const float *restrict origins,
    __global float *restrict jacobian) {
  const map_t map = THE_MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  fit_t fit;
  set_point(&map.cuts, &fit.point, load_points(points, points_count, first),
       load_points(origins, points_count, first));
  fit_map(&map, &fit);
  mat j = map_jacobian(&map, &fit);
  for (int i = 0; i < 9; ++i) store_plane(jacobian + i * points_count, j.a[i], points_count, first);
}
