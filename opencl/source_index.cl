// Where in the source grid the points of a grid take their material from.

#include "on_grid.cl"

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

// `to_source` takes indices of the grid to those of the source, `displacement_to_source` a
// displacement; unless `continued`, what a cut has opened is outside of everything.
#define SOURCE_PARAMETERS \
  const float16 to_source, const float16 displacement_to_source, const int continued, \
      __global float *restrict index

// Stores where in the source grid the points of a grid take their material from: continuous
// indices in three planes.
#if CUTS
#define VOID_DISTANCE void_distance_of(&map.cuts, fit.view.v, origin_of(&map.cuts, fit.view.v, d))
#define LEAVE_VOID_OUT if (!continued) from.x = select(from.x, (real)(-1e9f), VOID_DISTANCE < 0);
#else
#define LEAVE_VOID_OUT
#endif
#define STORE_SOURCE_INDEX                                                         \
  const vec d = moved(&map, &fit);                                                 \
  const vec step = transformed(displacement_to_source, d);                         \
  vec from = vec_add(transformed(to_source, here), step);                          \
  LEAVE_VOID_OUT                                                                   \
  STORE_KEPT(index, from.x)                                                        \
  STORE_KEPT(index + count, from.y)                                                \
  STORE_KEPT(index + 2 * count, from.z)
