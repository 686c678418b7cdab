#include "inverse.cl"

// v - x for points x less the mean displacement, in three planes that hold first guesses before.
// `residuals` are those of G(v) = x relative to the size of x.
__kernel EXPLICIT_VECTORS void point_inverse(
    MAP_ARGUMENTS, POINT_ARGUMENTS, __global float *restrict displacements,
    __global float *restrict residuals) {
  const map_t map = THE_MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first);
  vec displacement = load_points(displacements, points_count, first);
  real relative_residual;
  if (STEPS) {
    relative_residual = newton_by_steps(&map, x, &displacement);
  } else {
    if (CUTS) {
      const vec to_x = mean_displacement_of(&map.cuts);
      displacement = vec_select(displacement, to_x, is_blocked(&map, x, displacement));
    }
    relative_residual = newton(&map, x, x, INVERSE_TOLERANCE, (real)(MIN_SHARE), &displacement);
    relative_residual =
        select(relative_residual, (real)(FLT_MAX), is_cut_off(&map, x, displacement));
  }
  store_points(displacements, displacement, points_count, first);
  store_plane(residuals, relative_residual, points_count, first);
}
