// The backward map at points and on grids. Build constants: README.md.

#include "types.cl"
#include "powers.cl"
#if CUTS
#include "cuts.cl"
#endif
#include "weights.cl"
#if ROTATION
#include "fit_rotation.cl"
#else
#include "fit_polynomial.cl"
#endif
#include "lattice.cl"

// G(v) - v - drift; where no control point can be reached, nothing moves.
inline vec moved(const map_t *map, const fit_t *fit) {
  vec d = displacement_of(map, fit);
#if CUTS
  float4 drift = map->cuts.drift;
  d = vec_select(d, (vec){-drift.x, -drift.y, -drift.z}, fit->pivot.d2 >= UNREACHABLE);
#endif
  return d;
}

// d(G - v)/dv likewise.
inline mat moved_jacobian(const map_t *map, const fit_t *fit) {
  mat j = displacement_jacobian(map, fit);
#if CUTS
  for (int i = 0; i < 9; ++i) j.a[i] = select(j.a[i], (real)(0), fit->pivot.d2 >= UNREACHABLE);
#endif
  return j;
}

// G(v) - v - drift in three planes, local frame.
KERNEL void point_displacement(MAP_PARAMETERS, const long points_count,
                                 __global const float *restrict points,
                                 __global float *restrict displacement) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  fit_t fit = fit_at(&map, load_points(points, points_count, first));
  store_points(displacement, moved(&map, &fit), points_count, first);
}

// d(G - v)/dv in nine planes.
KERNEL void point_jacobian(MAP_PARAMETERS, const long points_count,
                             __global const float *restrict points,
                             __global float *restrict jacobian) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec v = load_points(points, points_count, first);
  fit_t fit = fit_at(&map, v);
  mat j = moved_jacobian(&map, &fit);
  for (int i = 0; i < 9; ++i) store_plane(jacobian + i * points_count, j.a[i], points_count, first);
}

#include "inverse.cl"

// For places x less drift the way to v with G(v) = x, from first guesses in `ways`, three planes;
// and what is left of it next to the size of x.
KERNEL void point_inverse(MAP_PARAMETERS, const long points_count,
                            __global const float *restrict points, __global float *restrict ways,
                            __global float *restrict left) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first), way = load_points(ways, points_count, first);
#if CUTS
  float4 drift = map.cuts.drift;  // to x itself
  way = vec_select(way, (vec){drift.x, drift.y, drift.z}, is_blocked(&map, x, way));
#endif
  real rest = newton(&map, x, &way);
  rest = select(rest, (real)(FLT_MAX), is_cut_off(&map, x, way));
  store_points(ways, way, points_count, first);
  store_plane(left, rest, points_count, first);
}

// For places x less drift the way to the best of some samples of the map, in three planes. Those that
// the map brings as near as `tried` (squared), or nearer, are left out.
KERNEL void nearest_sample(MAP_PARAMETERS, const long points_count,
                             __global const float *restrict points, const int sample_count,
                             __global const float *restrict samples, __global float *restrict tried,
                             __global float *restrict ways) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first);
  real distance2 = load_plane(tried, points_count, first);
  vec way = way_to_nearest(&map, x, sample_count, samples, &distance2);
  store_points(ways, way, points_count, first);
  store_plane(tried, distance2, points_count, first);
}

// For places x less drift v - x, world units, interleaved, from a lattice of first guesses; and what
// is left of the way next to the size of x.
KERNEL void point_forward(MAP_PARAMETERS, const long points_count,
                            __global const float *restrict points, GUESS_PARAMETERS,
                            const float scale, const float4 drift,
                            __global float *restrict displacement, __global float *restrict left) {
  const map_t map = MAP;
  const guess_t guess = GUESS;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first), way;
  mat response;
  guess_at(&guess, x, &way, &response);
  real rest = broyden(&map, x, &way, &response);
  rest = select(rest, (real)(FLT_MAX), is_cut_off(&map, x, way));
  way = vec_madd((real)(0), x, way);  // NaN stays NaN
  int lanes = (int)min((long)LANES, points_count - first);
  for (int l = 0; l < lanes; ++l) {
    __global float *to = displacement + 3 * (first + l);
    to[0] = fma(scale, LANE(way.x, l), -drift.x);
    to[1] = fma(scale, LANE(way.y, l), -drift.y);
    to[2] = fma(scale, LANE(way.z, l), -drift.z);
  }
  store_plane(left, rest, points_count, first);
}

// Lanes of a grid that belong to this launch.
#if CUTS
#define KEPT(l) LANE_INT(kept, l)
#define LEAVE_UNLESS_KEPT                      \
  integer kept = in_region(&map.cuts, here);   \
  if (!ANY(kept)) return;
#else
#define KEPT(l) 1
#define LEAVE_UNLESS_KEPT
#endif

// What every kernel over a grid begins with: indices of its points `at` and on, and the fit there.
#define FIT_ON_GRID                                          \
  const map_t map = MAP;                                     \
  const lattice_t lattice = LATTICE;                         \
  const long count = lattice.stop - lattice.first;           \
  const long at = (long)get_global_id(0) * LANES;            \
  if (at >= count) return;                                   \
  const int lanes = (int)min((long)LANES, count - at);       \
  const vec here = lattice_index(&lattice, lattice.first + at); \
  LEAVE_UNLESS_KEPT                                          \
  const fit_t fit = fit_at(&map, transformed(frame, here));

// G(v) - v, world units, interleaved, for the points `first` to `stop` of a grid; with cuts also the
// opening (cuts.cl), world units.
KERNEL void grid_displacement(MAP_PARAMETERS, LATTICE_PARAMETERS, const float scale,
                                const float4 drift, __global float *restrict displacement
#if CUTS
                                , __global float *restrict opening
#endif
) {
  FIT_ON_GRID
  vec d = moved(&map, &fit);
#if CUTS
  real open = opening_of(&map.cuts, fit.view.v, origin_of(&map.cuts, fit.view.v, d));
#endif
  for (int l = 0; l < lanes; ++l)
    if (KEPT(l)) {
      __global float *to = displacement + 3 * (at + l);
      to[0] = fma(scale, LANE(d.x, l), drift.x);
      to[1] = fma(scale, LANE(d.y, l), drift.y);
      to[2] = fma(scale, LANE(d.z, l), drift.z);
#if CUTS
      opening[at + l] = scale * LANE(open, l);
#endif
    }
}

// (dG/dv)^T, row by row, for the points `first` to `stop` of a grid.
KERNEL void grid_jacobian(MAP_PARAMETERS, LATTICE_PARAMETERS, __global float *restrict jacobian) {
  FIT_ON_GRID
  mat j = moved_jacobian(&map, &fit);
  for (int l = 0; l < lanes; ++l)
    if (KEPT(l))
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
          jacobian[9 * (at + l) + 3 * row + column] =
              LANE(j.a[3 * column + row], l) + (row == column);
}

// Stores the lanes of a plane that belong to this launch.
#if CUTS
#define STORE_KEPT(plane, value)                                 \
  if (ALL(kept)) {                                               \
    store_plane(plane, value, count, at);                        \
  } else {                                                       \
    for (int l = 0; l < lanes; ++l)                              \
      if (KEPT(l)) (plane)[at + l] = LANE(value, l);             \
  }
#else
#define STORE_KEPT(plane, value) store_plane(plane, value, count, at);
#endif

// `to_source` takes indices of the grid to those of the source, `turn` a displacement; unless
// `continued`, what a cut has opened is outside of everything.
#define SOURCE_PARAMETERS \
  const float16 to_source, const float16 turn, const int continued, __global float *restrict index

// Stores where in the source grid the points of a grid take their material from: continuous
// indices in three planes.
#if CUTS
#define OPENING opening_of(&map.cuts, fit.view.v, origin_of(&map.cuts, fit.view.v, d))
#define LEAVE_VOID_OUT if (!continued) from.x = select(from.x, (real)(-1e9f), OPENING < 0);
#else
#define LEAVE_VOID_OUT
#endif
#define STORE_SOURCE_INDEX                                                         \
  const vec d = moved(&map, &fit);                                                 \
  vec from = vec_add(transformed(to_source, here), transformed(turn, d));          \
  LEAVE_VOID_OUT                                                                   \
  STORE_KEPT(index, from.x)                                                        \
  STORE_KEPT(index + count, from.y)                                                \
  STORE_KEPT(index + 2 * count, from.z)

KERNEL void grid_source_index(MAP_PARAMETERS, LATTICE_PARAMETERS, SOURCE_PARAMETERS) {
  FIT_ON_GRID
  STORE_SOURCE_INDEX
}

// The same, and what turns a gradient there: after the indices follow nine planes of dG/dv. With
// cuts also the opening, local units times `scale`.
KERNEL void grid_source_frame(MAP_PARAMETERS, LATTICE_PARAMETERS, SOURCE_PARAMETERS
#if CUTS
                                , const float scale, __global float *restrict opening
#endif
) {
  FIT_ON_GRID
  STORE_SOURCE_INDEX
  const mat j = moved_jacobian(&map, &fit);
  for (int i = 0; i < 9; ++i) {
    const real entry = j.a[i] + (i % 4 == 0 ? 1.0f : 0.0f);
    STORE_KEPT(index + (3 + i) * count, entry)
  }
#if CUTS
  const real open = scale * OPENING;
  STORE_KEPT(opening, open)
#endif
}
