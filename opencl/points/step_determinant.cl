#include "map.cl"

// The smallest determinant of dG/dv of the steps at points of the deformed space; or, unless
// `step_index` is -1, that of this step at points of the stage that it leads from.
__kernel EXPLICIT_VECTORS void step_determinant(
    MAP_ARGUMENTS, POINT_ARGUMENTS, const int step_index, __global float *restrict determinants) {
  const map_t map = THE_MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  const map_t evaluated = step_index < 0 ? map : step_of(&map, step_index);
  fit_t fit = fit_at(&evaluated, load_points(points, points_count, first));
  real determinant;
  composed_jacobian(&evaluated, &fit, &determinant);
  store_plane(determinants, determinant, points_count, first);
}
