// Where in the source grid the points of a grid take their material from.

#include "on_grid.cl"

// Where in the source the points `index` take their material from, by their displacement d:
// continuous indices.
inline vec source_index_of(const source_t *source, vec index, vec d) {
  vec step = transformed(source->from_displacement, d);
  return vec_add(transformed(source->from_target, index), step);
}

// Outside of everything where points are in a void.
inline vec outside_if(vec from, integer is_void) {
  from.x = select(from.x, (real)(-1e9f), is_void);
  return from;
}

// Stores that in three planes.
inline void store_source_index(vec d, integer is_void, const item_t *item, const source_t *source,
                               __global float *index) {
  vec from = outside_if(source_index_of(source, item->index, d), is_void);
  store_kept(index, from.x, item);
  store_kept(index + item->count, from.y, item);
  store_kept(index + 2 * item->count, from.z, item);
}

inline void store_origin_of_fit(const map_t *map, const fit_t *fit, const item_t *item,
                                const source_t *source, __global float *index) {
  vec d = moved(map, fit);
  integer is_void = 0;
#if CUTS
  if (!source->continued) is_void = void_distance_at(map, fit, d) < 0;
#endif
  store_source_index(d, is_void, item, source, index);
}
