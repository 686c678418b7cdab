#include "map.cl"

// G(v) - v - mean displacement in three planes, local frame; the void distance in a fourth if cuts
// belong to the material.
__kernel EXPLICIT_VECTORS void point_displacement(
    MAP_ARGUMENTS, POINT_ARGUMENTS, __global float *restrict displacement) {
  const map_t map = THE_MAP;
  displace_points(&map, points_count, points, 0, displacement);
}
