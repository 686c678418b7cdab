#include "map.cl"
#include "grid.cl"

// The nodes of first guesses at the points of a grid; node_cell sets by_i.w.
__kernel EXPLICIT_VECTORS void node_origin(
    MAP_ARGUMENTS, const grid_t grid, __global node_t *restrict nodes) {
  const map_t map = THE_MAP;
  // before all branches: Mesa's compiler crashes where arguments are read below
  const long stop = grid.stop;
  vec by_index[3];
  for (int axis = 0; axis < 3; ++axis)
    by_index[axis] = (vec){grid.frame[3 * axis], grid.frame[3 * axis + 1], grid.frame[3 * axis + 2]};
  long first = grid.first + (long)get_global_id(0) * LANES;
  if (first >= stop) return;
  const fit_t fit = fit_at(&map, transformed(grid.frame, grid_index(&grid, first)));
  const vec x = origin_of(&map.cuts, start_of(&fit), map_displacement(&map, &fit));
  const weight_jacobian_t jacobian = map_weight_jacobian(&map, &fit);
  const mat d_dv = with_moving_origin(&jacobian);
  for (int axis = 0; axis < 3; ++axis)
    by_index[axis] = vec_add(by_index[axis], mat_vec(&d_dv, by_index[axis]));
  real slope2 = 0;
  for (int i = 0; i < 9; ++i) slope2 = fma(jacobian.d_dx.a[i], jacobian.d_dx.a[i], slope2);
  real slope = select(sqrt(slope2), (real)(-1), fit.point.view.crossed_cuts != 0);
  for (int l = 0; l < LANES && first + l < stop; ++l) {
    __global node_t *node = nodes + first + l;
    node->x = (float4)(LANE(x.x, l), LANE(x.y, l), LANE(x.z, l), LANE(slope, l));
    __global float4 *by = &node->by_i;
    for (int axis = 0; axis < 3; ++axis) {
      vec d = by_index[axis];
      by[axis] = (float4)(LANE(d.x, l), LANE(d.y, l), LANE(d.z, l), 0);
    }
  }
}
