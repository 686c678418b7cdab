#include "source_index.cl"
#include "coarse_map.cl"
#include "fine_map.cl"

// As grid_source_index, interpolated in listed fine cells.
__kernel EXPLICIT_VECTORS void fine_source_index(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const grid_t grid, const coarse_t fine, __global const int *restrict cells,
    __global const float *restrict fine_planes, const source_t source, __global float *restrict index,
    __global float *restrict void_distance, const float scale) {
  const map_t map = map_of(map_params, map_tables, cut_params, cut_tables);
  item_t item = item_of(&map, &grid, &fine, cells, 0, void_distance);
  if (item.lanes == 0) return;
  real values[PLANES];
  interpolate_places(values, &fine, fine_planes, cells, item.first);
  const vec d =
      limited_on_grid(&map, &grid, item.index, (vec){values[0], values[1], values[2]});
  integer is_void = 0;
#if CUTS
  if (!source.continued) is_void = values[3] < 0;
  if (void_distance) store_masked(void_distance, scale * values[3], &item);
#endif
  store_masked_planes(index, outside_if(source_index_of(&source, item.index, d), is_void), &item);
}
