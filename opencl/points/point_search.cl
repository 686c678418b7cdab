#include "map.cl"

// As point_displacement, for the material on the side of the cuts where `starts` are: the map continues
// behind the faces. Only with cuts in the rest frame.
__kernel EXPLICIT_VECTORS void point_search(
    MAP_ARGUMENTS, POINT_ARGUMENTS, __global const float *restrict starts,
    __global float *restrict displacement) {
  const map_t map = THE_MAP;
  displace_points(&map, points_count, points, starts, displacement);
}
