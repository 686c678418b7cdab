#include "source_index.cl"

// Source indices, and covariant vectors. Where regions compete, the void distances decide between them.
__kernel EXPLICIT_VECTORS void grid_source_index(MAP_ARGUMENTS, GRID_ARGUMENTS, SOURCE_ARGUMENTS) {
  const map_t map = THE_MAP;
  item_t item = item_of(&map, &grid, &coarse, cells, listed, void_distance);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item, &nodes, node_table);
  if (void_distance) store_void_distance(&item, &map, &fit, void_distance, scale);
  const vec d = map_displacement(&map, &fit);
  integer is_void = 0;
  if (CUTS && !source.continued) is_void = void_distance_at(&map, &fit, d) < 0;
  const vec from = source_index_of(&source, item.index, d, is_void);
  store_masked(index, from.x, &item);
  store_masked(index + item.count, from.y, &item);
  store_masked(index + 2 * item.count, from.z, &item);
  if (!HAS_VECTORS) return;
  const vec n = transposed_jacobian_vec(&map, &fit, vectors_at(&array, vectors, from));
  store_masked_points(covariant, normalize ? unit3(n) : n, &item);
}
