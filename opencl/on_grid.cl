// What the kernels over a grid share.

#include "map.cl"
#include "grid.cl"

// The points of a work item.
typedef struct {
  long at, count;  // the first of them, of how many in this launch
  int lanes;       // 0 where there is nothing to do
  vec index;       // in the whole grid
#if CUTS
  integer kept;    // whether the region of this launch has them
#endif
} item_t;

inline item_t item_of(const map_t *map, const grid_t *grid) {
  item_t item;
  item.at = (long)get_global_id(0) * LANES;
  item.count = grid->stop - grid->first;
  item.lanes = (int)clamp(item.count - item.at, (long)0, (long)LANES);
  if (item.lanes == 0) return item;
  item.index = grid_index(grid, grid->first + item.at);
#if CUTS
  item.kept = in_region(&map->cuts, item.index);
  if (!ANY(item.kept)) item.lanes = 0;
#endif
  return item;
}

// Whether lane l belongs to this launch.
inline int is_kept(const item_t *item, int l) {
#if CUTS
  return LANE_INT(item->kept, l);
#else
  return 1;
#endif
}

#if CUTS
// The void distance for the displacement d of the map (cuts.cl), local units.
inline real void_distance_at(const map_t *map, const fit_t *fit, vec d) {
  return void_distance_of(&map->cuts, fit->view.v, origin_of(&map->cuts, fit->view.v, d));
}
#endif
