#include "inverse.cl"

// v - x for points x less the mean displacement: world units, interleaved, from first guesses at the
// lattice nodes. `residuals` are those of G(v) = x relative to the size of x, FLT_MAX off the lattice.
__kernel EXPLICIT_VECTORS void point_forward(
    MAP_ARGUMENTS, POINT_ARGUMENTS, const lattice_t lattice, __global const float4 *restrict nodes,
    const world_t world, __global float *restrict result, __global float *restrict residuals) {
  const map_t map = THE_MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first), displacement;
  mat response;
  integer outside = !guess_at(&lattice, nodes, x, &displacement, &response);
  real relative_residual = broyden(&map, x, &displacement, &response);
  relative_residual = select(relative_residual, (real)(FLT_MAX),
                             outside | is_cut_off(&map, x, displacement));
  displacement = vec_madd((real)(0), x, displacement);  // NaN stays NaN
  const float *mean = world.mean_displacement;
  displacement = vec_madd(world.scale, displacement, (vec){-mean[0], -mean[1], -mean[2]});
  store_interleaved(result + 3 * first, displacement, (int)min((long)LANES, points_count - first));
  store_plane(residuals, relative_residual, points_count, first);
}
