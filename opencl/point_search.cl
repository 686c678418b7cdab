#include "map.cl"
#include "searches.cl"

// As point_displacement, for the material on the side of the cuts where `starts` are, which the map
// continues behind the faces; only with cuts in the rest frame.
KERNEL void point_search(MAP_PARAMETERS, const long points_count,
                         __global const float *restrict points,
                         __global const float *restrict starts,
                         __global float *restrict displacement) {
  const map_t map = MAP;
  search_points(&map, points_count, points, starts, displacement);
}
