#include "map.cl"

// d(G - v)/dv in nine planes.
__kernel EXPLICIT_VECTORS void point_jacobian(
    MAP_ARGUMENTS, POINT_ARGUMENTS, __global float *restrict jacobian) {
  const map_t map = THE_MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec v = load_points(points, points_count, first);
  fit_t fit = fit_at(&map, v);
  mat j = map_jacobian(&map, &fit);
  for (int i = 0; i < 9; ++i) store_plane(jacobian + i * points_count, j.a[i], points_count, first);
}
