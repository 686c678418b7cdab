// What the kernels over a grid share.

#include "map.cl"
#include "grid.cl"

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
  const grid_t grid = GRID;                         \
  const long count = grid.stop - grid.first;           \
  const long at = (long)get_global_id(0) * LANES;            \
  if (at >= count) return;                                   \
  const int lanes = (int)min((long)LANES, count - at);       \
  const vec here = grid_index(&grid, grid.first + at); \
  LEAVE_UNLESS_KEPT                                          \
  const fit_t fit = fit_at(&map, transformed(frame, here));
