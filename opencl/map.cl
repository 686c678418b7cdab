// The backward map at points and on grids. Build constants: README.md.

#include "types.cl"
#include "weights.cl"
#if ROTATION
#include "fit_rotation.cl"
#else
#include "fit_polynomial.cl"
#endif
#include "lattice.cl"

// G(v) - v - drift in three planes, local frame.
__kernel void point_displacement(MAP_PARAMETERS, const long points_count,
                                 __global const float *restrict points,
                                 __global float *restrict displacement) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  fit_t fit = fit_at(&map, load_points(points, points_count, first));
  store_points(displacement, displacement_of(&map, &fit), points_count, first);
}

// d(G - v)/dv in nine planes.
__kernel void point_jacobian(MAP_PARAMETERS, const long points_count,
                             __global const float *restrict points,
                             __global float *restrict jacobian) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec v = load_points(points, points_count, first);
  fit_t fit = fit_at(&map, v);
  mat j = displacement_jacobian(&map, &fit, v);
  for (int i = 0; i < 9; ++i) store_plane(jacobian + i * points_count, j.a[i], points_count, first);
}

// G(v) - v, world units, interleaved, for the points `first` to `stop` of a grid.
__kernel void grid_displacement(MAP_PARAMETERS, LATTICE_PARAMETERS, const float scale,
                                const float4 drift, __global float *restrict displacement) {
  const map_t map = MAP;
  const lattice_t lattice = LATTICE;
  long at = (long)get_global_id(0) * LANES;
  if (at >= lattice.stop - lattice.first) return;
  fit_t fit = fit_at(&map, transformed(frame, lattice_index(&lattice, lattice.first + at)));
  vec d = displacement_of(&map, &fit);
  int lanes = (int)min((long)LANES, lattice.stop - lattice.first - at);
  for (int l = 0; l < lanes; ++l) {
    __global float *to = displacement + 3 * (at + l);
    to[0] = fma(scale, LANE(d.x, l), drift.x);
    to[1] = fma(scale, LANE(d.y, l), drift.y);
    to[2] = fma(scale, LANE(d.z, l), drift.z);
  }
}

// Where in the source grid the points of a grid take their material from: continuous indices in
// three planes. `to_source` takes the grid's own indices there, `turn` a displacement.
__kernel void grid_source_index(MAP_PARAMETERS, LATTICE_PARAMETERS, const float16 to_source,
                                const float16 turn, __global float *restrict index) {
  const map_t map = MAP;
  const lattice_t lattice = LATTICE;
  long at = (long)get_global_id(0) * LANES, count = lattice.stop - lattice.first;
  if (at >= count) return;
  vec here = lattice_index(&lattice, lattice.first + at);
  fit_t fit = fit_at(&map, transformed(frame, here));
  vec from = vec_add(transformed(to_source, here), transformed(turn, displacement_of(&map, &fit)));
  store_points(index, from, count, at);
}
