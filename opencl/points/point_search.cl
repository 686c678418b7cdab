#include "map.cl"
#include "searches.cl"

// As point_displacement, for the material on the side of the cuts where `starts` are: the map continues
// behind the faces. Only with cuts in the rest frame.
__kernel EXPLICIT_VECTORS void point_search(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const long points_count, __global const float *restrict points,
    __global const float *restrict starts,
    __global float *restrict displacement) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  search_points(&map, points_count, points, starts, displacement);
}
