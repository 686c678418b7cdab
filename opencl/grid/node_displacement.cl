#include "map.cl"
#include "grid.cl"

// G(v) - v less its mean, before limits, local units, in three planes of `count` points; with cuts the
// void distance in a fourth.
__kernel EXPLICIT_VECTORS void node_displacement(
    const map_params_t map_params, __global const control_point_t *restrict control_points,
    __global const float *restrict kind_table, __global const region_t *restrict regions,
    __global const segment_t *restrict segments, __global const limit_t *restrict limits,
    __global const float *restrict images, __global const step_t *restrict steps,
    const cut_params_t cut_params, __global const plane_t *restrict planes,
    __global const float *restrict obstacles,
    const grid_t grid, const long count, __global float *restrict nodes) {
  const map_t map = map_of(map_params, control_points, kind_table, regions, segments, limits, images,
                           steps, cut_params, planes, obstacles);
  const long first = grid.first + (long)get_global_id(0) * LANES;
  if (first >= grid.stop) return;
  const fit_t fit = fit_at(&map, transformed(grid.frame, grid_index(&grid, first)));
#if STEPS  // where nothing is interpolated if there are limits
  store_points(nodes, map_displacement(&map, &fit), count, first);
#else
  store_points(nodes, unlimited_displacement(&map, &fit), count, first);
#endif
#if CUTS
  const real distance = void_distance_at(&map, &fit, map_displacement(&map, &fit));
  store_plane(nodes + 3 * count, distance, count, first);
#endif
}
