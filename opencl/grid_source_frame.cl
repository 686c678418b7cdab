#include "source_index.cl"

// The same, and the Jacobian for a gradient there: after the indices follow nine planes of dG/dv.
// With cuts also the void distance, local units times `scale`.
KERNEL void grid_source_frame(MAP_PARAMETERS, const grid_t grid, const source_t source,
                              __global float *restrict index
#if CUTS
                              , const float scale, __global float *restrict void_distance
#endif
) {
  const map_t map = MAP;
  const item_t item = item_of(&map, &grid);
  if (item.lanes == 0) return;
  const fit_t fit = fit_at(&map, transformed(grid.frame, item.index));
  store_source_index(&map, &fit, &item, &source, index);
  const mat j = moved_jacobian(&map, &fit);
  for (int i = 0; i < 9; ++i)
    store_kept(index + (3 + i) * item.count, j.a[i] + (i % 4 == 0 ? 1.0f : 0.0f), &item);
#if CUTS
  store_kept(void_distance, scale * void_distance_at(&map, &fit, moved(&map, &fit)), &item);
#endif
}
