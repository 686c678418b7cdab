#include "on_grid.cl"

#define OFF 1         // in the middle of the cell the map is not what is interpolated there
#define ELSEWHERE 2   // no point of the cell is in the region of the launch

#if CUTS
// From where cuts see what is at v, of a displacement d.
inline vec seen_from(const cuts_t *cuts, vec v, vec d) {
#if AT_REST
  return origin_of(cuts, v, d);
#else
  return v;
#endif
}

// Whether a cut may be in the cells: between the middle and a corner, or no farther from the middle,
// or there is a void in only a part of them. `index` is that of the first corners.
inline integer is_parted(const map_t *map, const grid_t *grid, const coarse_t *coarse,
                         __global const float *nodes, long node, vec index, vec d, real distance) {
  const cuts_t *cuts = &map->cuts;
  const long plane = node_count(coarse), along = coarse->nodes[0];
  const real share = COARSE_STEP / 2;
  const vec middle = seen_from(
      cuts, transformed(grid->frame, vec_add(index, (vec){share, share, share})), d);
  integer parted = 0;
#if RIVALS
  parted |= distance < 0;  // here regions compete
#endif
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    __global const float *at = nodes + node + i + along * (j + (long)coarse->nodes[1] * k);
    const vec step = {(real)(i * COARSE_STEP), (real)(j * COARSE_STEP), (real)(k * COARSE_STEP)};
    const vec there = seen_from(cuts, transformed(grid->frame, vec_add(index, step)),
                                (vec){LOAD(at), LOAD(at + plane), LOAD(at + 2 * plane)});
    const vec apart = vec_sub(there, middle);
    parted |= (LOAD(at + 3 * plane) < 0) != (distance < 0);
    parted |= blocked(cuts, middle, there) | !(dot3(apart, apart) < distance * distance);
  }
  return parted;
}
#endif

// Holds the map in the middles of cells against what is interpolated there.
KERNEL void coarse_check(MAP_PARAMETERS, const grid_t grid, const coarse_t coarse, const check_t check,
                         __global const float *restrict nodes,
                         __global const float *restrict middles, __global uchar *restrict is_far) {
#if CUTS
  const map_t map = MAP;
#endif
  strip_t strip;
  if (!strip_of(&coarse, &strip)) return;
  const int middle = COARSE_STEP / 2, x = strip.x - coarse.first_cell[0];
  layer_t layer;
  layer_between(&layer, &coarse, nodes, &strip, middle, NO_SLOPE);
  const long plane = (long)coarse.cells[0] * coarse.cells[1] * coarse.cells[2];
  const long at = x + coarse.cells[0] * (strip.y - coarse.first_cell[1] +
                                        (long)coarse.cells[1] * (strip.z - coarse.first_cell[2]));
  real middles_there[PLANES], error[PLANES];
  for (int p = 0; p < PLANES; ++p) {
    middles_there[p] = LOAD(middles + p * plane + at);
    error[p] = points_between(&layer, p, middle, middle, 0) - middles_there[p];
  }
  vec off = transformed(check.to_index, (vec){error[0], error[1], error[2]});
  integer found = select((integer)(OFF), (integer)(0), dot3(off, off) <= check.limit2);
#if CUTS
  const vec index = corners_of(&strip);
  const vec d = {middles_there[0], middles_there[1], middles_there[2]};
  const real distance = middles_there[3];
  integer parted = is_parted(&map, &grid, &coarse, nodes, node_of(&coarse, &strip), index, d,
                             distance);
  parted |= !(fabs(error[3]) <= 0.25f * fabs(distance));
  found = select(found, (integer)(OFF), parted);
  found |= select((integer)(ELSEWHERE), (integer)(0), in_reach(&map.cuts, index));
#endif
  for (int l = 0; l < LANES && x + l < coarse.cells[0]; ++l)
    is_far[at + l] = (uchar)LANE_INT(found, l);
}
