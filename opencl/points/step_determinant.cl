#include "map.cl"

// The smallest determinant of dG/dv of the steps at points of the deformed space.
__kernel EXPLICIT_VECTORS void step_determinant(
    MAP_ARGUMENTS, POINT_ARGUMENTS, __global float *restrict determinants) {
  const map_t map = THE_MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  fit_t fit = fit_at(&map, load_points(points, points_count, first));
  real determinant;
  composed_jacobian(&map, &fit, &determinant);
  store_plane(determinants, determinant, points_count, first);
}
