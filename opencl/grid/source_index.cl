// Source indices of the points of a grid: where their material comes from.

#include "on_grid.cl"

// Continuous source indices of the target indices `index`, for local displacements d.
inline vec source_index_of(const source_t *source, vec index, vec d) {
  vec step = transformed(source->from_displacement, d);
  return vec_add(transformed(source->from_target, index), step);
}

// An index outside of any source where points are void.
inline vec outside_if(vec from, integer is_void) {
  from.x = select(from.x, (real)(-1e9f), is_void);
  return from;
}

// Stores vectors of the points of a work item in three planes.
inline void store_masked_planes(__global float *planes, vec value, const item_t *item) {
  store_masked(planes, value.x, item);
  store_masked(planes + item->count, value.y, item);
  store_masked(planes + 2 * item->count, value.z, item);
}

// The source indices of a work item for displacements by the map.
inline vec source_index_of_fit(const map_t *map, const fit_t *fit, const item_t *item,
                               const source_t *source) {
  const vec d = map_displacement(map, fit);
  const vec from = source_index_of(source, item->index, d);
  if (!CUTS || source->continued) return from;
  return outside_if(from, void_distance_at(map, fit, d) < 0);
}
