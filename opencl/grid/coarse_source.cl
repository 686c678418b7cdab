// Source indices of points between the nodes of a coarse map.

#include "source_index.cl"
#include "coarse_map.cl"

// Where they are stored: planes of `index`, and void distances unless null, `scale` times the local ones.
typedef struct {
  const source_t *source;
  __global float *index, *void_distance;
  float scale;
} source_planes_t;

// Stores the source indices of the n-th LANES of a row for local displacements d before limits, and the void
// distances, which are `distance` with cuts. Returns the indices.
inline vec store_source_in_row(const source_planes_t *to, const map_t *map, const grid_t *grid,
                               const row_t *row, int n, vec d, real distance) {
  const vec at = indices_in(row, n);
  vec from = source_index_of(to->source, at, limited_on_grid(map, grid, at, d));
  const integer mask = launch_mask(map, row, n);
  if (CUTS && !to->source->continued) from = outside_if(from, distance < 0);
  if (CUTS && to->void_distance)
    store_in_row(to->void_distance, to->scale * distance, row, n, mask);
  store_vec_in_row(to->index, grid->stop - grid->first, from, row, n, mask);
  return from;
}
