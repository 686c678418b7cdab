#include "map.cl"

// The smallest determinant of dG/dv of the steps at points of the deformed space; or that of step `only`,
// if it is not -1, at points of the stage that it leads from.
__kernel EXPLICIT_VECTORS void step_determinant(
    const map_params_t map_params, __global const control_point_t *restrict control_points,
    __global const float *restrict kind_table, __global const region_t *restrict regions,
    __global const segment_t *restrict segments, __global const limit_t *restrict limits,
    __global const float *restrict images, __global const step_t *restrict steps,
    const cut_params_t cut_params, __global const plane_t *restrict planes,
    __global const float *restrict obstacles,
    const long points_count, __global const float *restrict points, const int only,
    __global float *restrict determinants) {
  const map_t map = map_of(map_params, control_points, kind_table, regions, segments, limits, images,
                           steps, cut_params, planes, obstacles);
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  const map_t looked_at = only < 0 ? map : step_of(&map, only);
  fit_t fit = fit_at(&looked_at, load_points(points, points_count, first));
  real determinant;
  composed_jacobian(&looked_at, &fit, &determinant);
  store_plane(determinants, determinant, points_count, first);
}
