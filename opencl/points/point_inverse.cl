#include "inverse.cl"

// v - x for points x less the mean displacement, in three planes that hold first guesses before. `left`
// is the residual of G(v) = x relative to the size of x.
__kernel EXPLICIT_VECTORS void point_inverse(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const long points_count, __global const float *restrict points,
    __global float *restrict displacements, __global float *restrict left) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first);
  vec displacement = load_points(displacements, points_count, first);
#if STEPS
  real rest = newton_by_steps(&map, x, &displacement);
#else
#if CUTS
  vec to_x = mean_displacement_of(&map.cuts);
  displacement = vec_select(displacement, to_x, is_blocked(&map, x, displacement));
#endif
  real rest = newton(&map, x, x, &displacement);
  rest = select(rest, (real)(FLT_MAX), is_cut_off(&map, x, displacement));
#endif
  store_points(displacements, displacement, points_count, first);
  store_plane(left, rest, points_count, first);
}
