// Where in the source grid the points of a grid take their material from.

#include "on_grid.cl"

#ifndef SOURCE
#error "SOURCE is missing: members of the struct below"
#endif

// `from_target` takes indices of the grid to those of the source, `from_displacement` a
// displacement; unless `continued`, what a cut has opened is outside of everything.
typedef struct { SOURCE } source_t;

// Stores where in the source the points take their material from: continuous indices in three
// planes.
inline void store_source_index(const map_t *map, const fit_t *fit, const item_t *item,
                               const source_t *source, __global float *index) {
  vec d = moved(map, fit);
  vec step = transformed(source->from_displacement, d);
  vec from = vec_add(transformed(source->from_target, item->index), step);
#if CUTS
  if (!source->continued)
    from.x = select(from.x, (real)(-1e9f), void_distance_at(map, fit, d) < 0);
#endif
  store_kept(index, from.x, item);
  store_kept(index + item->count, from.y, item);
  store_kept(index + 2 * item->count, from.z, item);
}
