// What the kernels over a grid share.

#include "map.cl"
#include "lattice.cl"

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
