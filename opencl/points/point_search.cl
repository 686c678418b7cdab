#include "map.cl"
#include "searches.cl"

// As point_displacement, for the material on the side of the cuts where `starts` are: the map continues
// behind the faces. Only with cuts in the rest frame.
__kernel EXPLICIT_VECTORS void point_search(
    const map_params_t map_params, __global const control_point_t *restrict control_points,
    __global const float *restrict kind_table, __global const region_t *restrict regions,
    __global const segment_t *restrict segments, __global const limit_t *restrict limits,
    __global const float *restrict images, __global const step_t *restrict steps,
    const cut_params_t cut_params, __global const plane_t *restrict planes,
    __global const float *restrict obstacles,
    const long points_count, __global const float *restrict points,
    __global const float *restrict starts,
    __global float *restrict displacement) {
  const map_t map = map_of(map_params, control_points, kind_table, regions, segments, limits, images,
                           steps, cut_params, planes, obstacles);
  search_points(&map, points_count, points, starts, displacement);
}
