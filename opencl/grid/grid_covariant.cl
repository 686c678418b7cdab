#include "source_index.cl"
#include "vectors.cl"

// As grid_source_index; and covariant vectors J^T n(G(v)) (Eq. 29) for the vectors n of an array, of
// length 1 (or 0) if `normalize`.
__kernel EXPLICIT_VECTORS void grid_covariant(
    MAP_ARGUMENTS, GRID_ARGUMENTS, const source_t source, __global float *restrict index,
    __global float *restrict void_distance, const float scale, const array_t array,
    const int normalize, __global const float *restrict vectors, __global float *restrict result) {
  const map_t map = THE_MAP;
  item_t item = item_of(&map, &grid, &coarse, cells, listed, void_distance);
  if (item.lanes == 0) return;
  const fit_t fit = fit_on_grid(&map, &grid, &item, &nodes, node_table);
  if (void_distance) store_void_distance(&item, &map, &fit, void_distance, scale);
  const vec from = source_index_of_fit(&map, &fit, &item, &source);
  store_masked_planes(index, from, &item);
  const vec n = transposed_jacobian_vec(&map, &fit, vectors_at(&array, vectors, from));
  store_masked_points(result, normalize ? unit3(n) : n, &item);
}
