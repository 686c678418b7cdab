#include "map.cl"
#include "grid.cl"

#define MAX_GUESS_ERROR 0.1f  // local units

// Member `at` of nodes: at 0 x, at 1 to 3 its changes; the fourth component goes to `w`.
inline vec load_nodes(__global const node_t *nodes, integer n, int at, real *w) {
  vec value;
  for (int l = 0; l < LANES; ++l) {
    float4 node = ((__global const float4 *)(nodes + LANE_INT(n, l)))[at];
    set_lane(&value, l, node.xyz);
    LANE(*w, l) = node.w;
  }
  return value;
}

// For the cells above nodes, of `count` in all, the largest norm of dG/dx at the corners; -1 where the
// cell gives no guess: a cut separates its corners, one is behind a cut, or its first node does not
// predict the others.
__kernel EXPLICIT_VECTORS void node_cell(
    MAP_ARGUMENTS, const grid_t grid, const int count, __global node_t *restrict nodes) {
  const map_t map = THE_MAP;
  long first = grid.first + (long)get_global_id(0) * LANES;
  if (first >= grid.stop) return;
  integer n, usable = (real)(0) == 0;
  for (int l = 0; l < LANES; ++l) LANE_INT(n, l) = min((int)first + l, count - 1);
  real largest = 0, slope;
  vec x = load_nodes(nodes, n, 0, &slope), by[3];
  for (int axis = 0; axis < 3; ++axis) by[axis] = load_nodes(nodes, n, 1 + axis, &slope);
  for (int corner = 0; corner < 8; ++corner) {
    const int up[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    const int above = up[0] + grid.nx * (up[1] + grid.ny * up[2]);
    vec corner_x = load_nodes(nodes, min(n + above, (integer)(count - 1)), 0, &slope), guess = x;
    for (int axis = 0; axis < 3; ++axis)
      guess = vec_madd((real)(up[axis]), by[axis], guess);
    vec miss = vec_sub(corner_x, guess);
    usable &= (slope >= 0) & (dot3(miss, miss) < MAX_GUESS_ERROR * MAX_GUESS_ERROR);
    usable &= !blocked(&map.cuts, x, corner_x);
    largest = fast_max(largest, slope);
  }
  slope = select((real)(-1), largest, usable);
  for (int l = 0; l < LANES && first + l < grid.stop; ++l)
    nodes[first + l].by_i.w = LANE(slope, l);
}
