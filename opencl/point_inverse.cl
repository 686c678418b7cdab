#include "inverse.cl"

// For points x less the mean displacement the displacement to v with G(v) = x, from first guesses in
// `displacements`, three planes; and what is left of it next to the size of x.
KERNEL void point_inverse(MAP_PARAMETERS, const long points_count,
                          __global const float *restrict points,
                          __global float *restrict displacements,
                          __global float *restrict left) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first);
  vec displacement = load_points(displacements, points_count, first);
#if CUTS
  vec to_x = mean_displacement_of(&map.cuts);
  displacement = vec_select(displacement, to_x, is_blocked(&map, x, displacement));
#endif
  real rest = newton(&map, x, &displacement);
  rest = select(rest, (real)(FLT_MAX), is_cut_off(&map, x, displacement));
  store_points(displacements, displacement, points_count, first);
  store_plane(left, rest, points_count, first);
}
