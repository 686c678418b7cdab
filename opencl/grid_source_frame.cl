#include "source_index.cl"

// What grid_source_index writes, and the Jacobian for a gradient there: after the indices follow nine
// planes of dG/dv.
KERNEL void grid_source_frame(MAP_PARAMETERS, const grid_t grid NODE_PARAMETERS ITEM_PARAMETERS,
                              const source_t source,
                              __global float *restrict index
#if CUTS
                              VOID_PARAMETERS
#endif
) {
  map_t map = MAP;
  item_t item = ITEM_OF_LAUNCH(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item NODES_OF_LAUNCH);
#if CUTS
  if (void_distance) store_void_distance(&item, &map, &fit, VOID_OF_LAUNCH);
#endif
  store_origin_of_fit(&map, &fit, &item, &source, index);
  const mat j = moved_jacobian(&map, &fit);
  for (int i = 0; i < 9; ++i)
    store_kept(index + (3 + i) * item.count, j.a[i] + (i % 4 == 0 ? 1.0f : 0.0f), &item);
}
