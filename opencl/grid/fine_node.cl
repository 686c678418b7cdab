#include "map.cl"
#include "grid.cl"
#include "coarse_map.cl"
#include "fine_map.cl"

// The fine nodes of listed cells of the coarse map, interpolated between its nodes. Those at its nodes and
// in the `middles` of its cells are exact, but not in cells that are `sure`, if that is not null.
__kernel EXPLICIT_VECTORS void fine_node(
    const map_params_t map_params, __global const float *restrict map_tables,
    const cut_params_t cut_params, __global const float *restrict cut_tables,
    const coarse_t coarse, __global const int *restrict cells,
    __global const float *restrict node_planes, __global const float *restrict middles,
    __global const uchar *restrict sure, const coarse_t fine, __global float *restrict fine_planes) {
  const long first = (long)get_global_id(0) * LANES;
  if (first / PLACES >= coarse.listed) return;
  real values[PLANES];
  interpolate_places(values, &coarse, node_planes, cells, first);
  const long plane = (long)coarse.cells[0] * coarse.cells[1] * coarse.cells[2];
  for (int l = 0; l < LANES && (first + l) / PLACES < coarse.listed; ++l) {
    const int cell = listed_cell(&coarse, cells, (first + l) / PLACES);
    const int place = (int)((first + l) % PLACES);
    const int3 corner = cell_corner(&coarse, cell) +
                        (int3)(coarse.first_node[0], coarse.first_node[1], coarse.first_node[2]);
    const int3 node = corner * (COARSE_STEP / FINE_STEP) + (int3)(place & 1, place >> 1 & 1, place >> 2) -
                      (int3)(fine.first_node[0], fine.first_node[1], fine.first_node[2]);
    const int is_middle = place == PLACES - 1 && !(sure && sure[cell]);
    for (int p = 0; p < PLANES; ++p)
      fine_planes[node_at(&fine, node) + p * node_count(&fine)] =
          is_middle ? middles[cell + p * plane] : LANE(values[p], l);
  }
}
