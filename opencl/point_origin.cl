#include "map.cl"
#include "origin_nodes.cl"

// As point_displacement, where the nodes of a grid over most points say from where to see the cuts;
// elsewhere the void distance is NaN. Only with cuts in the rest frame.
KERNEL void point_origin(MAP_PARAMETERS, const long points_count,
                         __global const float *restrict points, const node_grid_t grid,
                         __global const node_t *restrict node_table,
                         __global float *restrict displacement) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec v = load_points(points, points_count, first);
  start_t start = start_among(&map, &grid, node_table, v);
  fit_t fit;
  look(&map.cuts, &fit.view, v, start.x);
  fit_view(&map, &fit);
  vec d = moved(&map, &fit);
  store_points(displacement, d, points_count, first);
  vec x = origin_of(&map.cuts, v, d);
  real nothing = void_distance_of(&map.cuts, x, x, (integer)(0));
  nothing = select((real)(NAN), nothing, is_foreseen(&start, x));
  store_plane(displacement + 3 * points_count, nothing, points_count, first);
}
