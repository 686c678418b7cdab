#include "types.cl"
#include "lattice.cl"

// The lattice cells of local points.
__kernel EXPLICIT_VECTORS void lattice_cells(
    const long points_count, __global const float *restrict points, const lattice_t lattice,
    __global int *restrict cells) {
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec share;
  real shrink;
  integer node;
  vec x = load_points(points, points_count, first);
  integer cell = lattice_cell(&lattice, x, &share, &shrink, &node);
  int lanes = (int)min((long)LANES, points_count - first);
  for (int l = 0; l < lanes; ++l) cells[first + l] = min(LANE_INT(cell, l), LATTICE_SIZE);
}
