// The map where many control points are: those far away count by clusters (vtk_mls/clusters.py).

// Which rows of the tables of the map count for the group of points number n of a launch:
// `spans[n].y` of them, from `spans[n].x` on in `listed`.
#define LIST_PARAMETERS \
  , __global const int2 *restrict spans, __global const int *restrict listed
#define LISTS_OF_LAUNCH spans, listed

// Lets those of a group count, of `groups`.
inline void take_list(map_t *map, __global const int2 *spans, __global const int *listed,
                      long group, long groups) {
  const int2 span = spans[min(group, groups - 1)];
  map->listed = listed + span.x;
  map->numbers.count = span.y;
}
