#include "map.cl"
#include "grid.cl"
#include "origin_nodes.cl"

#define FORESIGHT 0.01f  // local units

// Four numbers of nodes, of which the last is `beside`: at 0 x, at 1 to 3 its changes.
inline vec load_nodes(__global const node_t *nodes, integer n, int at, real *beside) {
  vec value;
  for (int l = 0; l < LANES; ++l) {
    float4 node = ((__global const float4 *)(nodes + LANE_INT(n, l)))[at];
    LANE(value.x, l) = node.x;
    LANE(value.y, l) = node.y;
    LANE(value.z, l) = node.z;
    LANE(*beside, l) = node.w;
  }
  return value;
}

// For the cells above nodes, of `count` in all, the largest norm of dG/dx among the corners. It is
// -1 where these give no guess: a cut parts them, material is behind one, or the first node does
// not foresee the others.
KERNEL void node_cell(MAP_PARAMETERS, const grid_t grid, const int count,
                      __global node_t *restrict nodes) {
  const map_t map = MAP;
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
    vec there = load_nodes(nodes, min(n + above, (integer)(count - 1)), 0, &slope), foreseen = x;
    for (int axis = 0; axis < 3; ++axis)
      foreseen = vec_madd((real)(up[axis]), by[axis], foreseen);
    vec miss = vec_sub(there, foreseen);
    usable &= (slope >= 0) & (dot3(miss, miss) < FORESIGHT * FORESIGHT);
    usable &= !blocked(&map.cuts, x, there);
    largest = most(largest, slope);
  }
  slope = select((real)(-1), largest, usable);
  for (int l = 0; l < LANES && first + l < grid.stop; ++l)
    nodes[first + l].by_i.w = LANE(slope, l);
}
