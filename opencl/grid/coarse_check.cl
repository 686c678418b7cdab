#include "on_grid.cl"
#include "coarse_map.cl"

// The point from which cuts see the material at `index` with the displacement d before limits.
inline vec viewpoint_of(const map_t *map, const grid_t *grid, vec index, vec d) {
  const vec v = transformed(grid->frame, index);
  return AT_REST ? origin_of(&map->cuts, v, limited_on_grid(map, grid, index, d)) : v;
}

// Whether a cut may be in a cell: it separates the middle from a corner, or is no farther from the
// middle than a corner, or only a part of the cell is void. `index` is that of the first corners.
inline integer is_separated(const map_t *map, const grid_t *grid, const coarse_t *coarse,
                            __global const float *node_planes, long node, vec index, vec d,
                            real distance) {
  const cuts_t *cuts = &map->cuts;
  const long plane = node_count(coarse), along = coarse->nodes[0];
  const real share = COARSE_STEP / 2;
  const vec middle = viewpoint_of(map, grid, vec_add(index, (vec){share, share, share}), d);
  integer separated = 0;
  if (regions_compete(cuts)) separated |= distance < 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    __global const float *at =
        node_planes + node + i + along * (j + (long)coarse->nodes[1] * k);
    const vec step = {(real)(i * COARSE_STEP), (real)(j * COARSE_STEP), (real)(k * COARSE_STEP)};
    const vec end = viewpoint_of(map, grid, vec_add(index, step),
                                 (vec){LOAD(at), LOAD(at + plane), LOAD(at + 2 * plane)});
    const vec apart = vec_sub(end, middle);
    separated |= (LOAD(at + (PLANES - 1) * plane) < 0) != (distance < 0);
    separated |= blocked(cuts, middle, end) | !(dot3(apart, apart) < distance * distance);
  }
  return separated;
}

// Compares the map in the `middles` of cells with its interpolation: bits of structs.h.
__kernel EXPLICIT_VECTORS void coarse_check(
    MAP_ARGUMENTS, const grid_t grid, const coarse_t coarse, const check_t check,
    __global const float *restrict node_planes, __global const float *restrict middles,
    __global uchar *restrict flags) {
  const map_t map = THE_MAP;
  band_t band;
  if (!find_band(&coarse, &band)) return;
  const int middle = COARSE_STEP / 2, x = band.x - coarse.first_cell[0];
  const long first = x + coarse.cells[0] * (band.y - coarse.first_cell[1] +
                                           (long)coarse.cells[1] * (band.z - coarse.first_cell[2]));
  const long along = coarse.nodes[0], deep = along * coarse.nodes[1];
  __global const float *corner =
      node_planes + node_of(&coarse, &band, 0) - BEFORE * (1 + along + deep);
  real rows[BAND + TAPS - 1][PLANES];
  for (int a = 0; a < band.count + TAPS - 1; ++a)
    for (int p = 0; p < PLANES; ++p) {
      real tap[TAPS];
      taps_along_x(tap, corner + a * along + p * node_count(&coarse), deep, middle, 0);
      rows[a][p] = interpolate(tap, middle, 0);
    }
  const long plane = (long)coarse.cells[0] * coarse.cells[1] * coarse.cells[2];
  for (int b = 0; b < band.count; ++b) {
    const long at = first + b * coarse.cells[0];
    real interpolated[PLANES], exact[PLANES];
    for (int p = 0; p < PLANES; ++p) {
      real tap[TAPS];
      UNROLL_ALL for (int a = 0; a < TAPS; ++a) tap[a] = rows[b + a][p];
      exact[p] = LOAD(middles + p * plane + at);
      interpolated[p] = interpolate(tap, middle, 0);
    }
    integer bits = accuracy_flags(&check, interpolated, exact);
    if (CUTS) {
      const vec index = first_corners(&band, b), d = {exact[0], exact[1], exact[2]};
      const integer separated = is_separated(&map, &grid, &coarse, node_planes,
                                             node_of(&coarse, &band, b), index, d, exact[PLANES - 1]);
      bits = select(bits, (integer)(INACCURATE | SPREADS), separated);
      bits |= select((integer)(OTHER_REGION), (integer)(0),
                     may_be_in_region(&map.cuts, index, COARSE_STEP));
    }
    for (int l = 0; l < min(LANES, coarse.cells[0] - x); ++l)
      flags[at + l] = (uchar)LANE_INT(bits, l);
  }
}
