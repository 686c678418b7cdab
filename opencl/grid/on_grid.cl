// Points of kernels over a grid, and stores of their values.
//
// Where full cuts belong to the material (`regions_compete`), material of several regions may come to
// a point. The first pass of a region computes the points where its own material is expected. The
// second pass computes those of other regions that are void so far, and keeps a point where its own
// void distance is larger.

#include "map.cl"
#include "grid.cl"

// Arguments of kernels on a grid: its points, nodes of first guesses, and listed cells or points.
#define GRID_ARGUMENTS                                                                \
  const grid_t grid, const nodes_t nodes, __global const node_t *restrict node_table, \
      const coarse_t coarse, __global const int *restrict cells,                      \
      __global const long *restrict listed

// Which points a work item has: CONSECUTIVE ones, those with the indices `listed`, or those of `cells`;
// the pointers of the others are null. A constant: tests of the pointers cost 2 to 3 % of the time of
// small fits.
enum { CONSECUTIVE = 0, LISTED = 1, CELLS = 2 };
#ifndef POINTS
#define POINTS CONSECUTIVE
#endif

enum {
  CELL_POINTS = COARSE_STEP * COARSE_STEP * COARSE_STEP,
  CELL_LANES = LANES < CELL_POINTS ? LANES : CELL_POINTS  // that share a cell
};

// LANES points of a work item.
typedef struct {
  long first, count;  // position of the first point, number of points in the launch
  int lanes;          // 0 where there is nothing to do
  int is_scattered;   // whether the points are not consecutive, or not all in the launch
  vec index;          // in the whole grid
  integer mask;       // lanes that are in the launch
  integer positions;  // of the lanes in the launch, of points of listed cells
} item_t;

// Points of listed cells.
inline void set_cell_points(item_t *item, const grid_t *grid, const coarse_t *coarse,
                            __global const int *cells) {
  const long first = (long)get_global_id(0) * LANES, first_entry = first / CELL_POINTS;
  item->lanes = first_entry < coarse->listed ? LANES : 0;
  if (item->lanes == 0) return;
  integer i = 0, j = 0, k = 0;
  item->mask = item->positions = 0;
  for (int lane = 0; lane < LANES; lane += CELL_LANES) {
    const long entry = min(first_entry + lane / CELL_LANES, coarse->listed - 1);
    const int is_listed = first_entry + lane / CELL_LANES < coarse->listed;
    const int cell = cells[coarse->first_listed + entry], nx = coarse->cells[0];
    // the cell in the grid, and its first point in the launch
    const int x = (coarse->first_cell[0] + cell % nx) * COARSE_STEP - grid->start[0],
              y = (coarse->first_cell[1] + cell / nx % coarse->cells[1]) * COARSE_STEP - grid->start[1],
              z = (coarse->first_cell[2] + cell / nx / coarse->cells[1]) * COARSE_STEP - grid->start[2];
    const long corner = x + grid->nx * (y + (long)grid->ny * z) - grid->first;
    const long limit = 1 << 30;  // beyond all points of a cell
    const int least = (int)clamp(-corner, -limit, limit),
              end = (int)clamp(item->count - corner, -limit, limit);
    const integer own = lane_indices() - lane, point = own + (int)(first % CELL_POINTS);
    const integer a = point & (COARSE_STEP - 1), b = point / COARSE_STEP & (COARSE_STEP - 1),
                  c = point / (COARSE_STEP * COARSE_STEP);
    const integer from_corner = a + grid->nx * (b + grid->ny * c);
    const integer is_own = own >= 0;  // else of a cell before
    integer mask = (a + x >= 0) & (a + x < grid->nx) & (b + y >= 0) & (b + y < grid->ny) &
                   (c + z >= 0) & (from_corner >= least) & (from_corner < end);
    if (!is_listed) mask = 0;
    item->mask = select(item->mask, mask, is_own);
    item->positions = select(item->positions, from_corner + (int)corner, is_own);
    i = select(i, a + (x + grid->start[0]), is_own);
    j = select(j, b + (y + grid->start[1]), is_own);
    k = select(k, c + (z + grid->start[2]), is_own);
  }
  item->index = (vec){TO_REAL(i), TO_REAL(j), TO_REAL(k)};
  if (!ANY(item->mask)) item->lanes = 0;
}

// The points of a work item.
inline item_t item_of(const map_t *map, const grid_t *grid, const coarse_t *coarse,
                      __global const int *cells, __global const long *listed,
                      __global const float *void_distance) {
  item_t item;
  item.first = (long)get_global_id(0) * LANES;
  item.count = grid->stop - grid->first;
  item.is_scattered = POINTS == CELLS;
  if (POINTS == CELLS) {
    set_cell_points(&item, grid, coarse, cells);
    if (item.lanes == 0) return item;
  } else {
    item.lanes = (int)clamp(item.count - item.first, (long)0, (long)LANES);
    if (item.lanes == 0) return item;
    item.mask = (real)(0) == 0;
    if (POINTS == LISTED)
      item.index = listed_index(grid, listed, item.count, item.first);
    else
      item.index = grid_index(grid, grid->first + item.first);
  }
  if (!CUTS) return item;
  item.mask &= in_region(&map->cuts, item.index);
  if (is_second_pass(&map->cuts))
    item.mask = !item.mask & (load_plane(void_distance, item.count, item.first) < 0);
  item.is_scattered |= !ALL(item.mask);
  if (!ANY(item.mask)) item.lanes = 0;
  return item;
}

// Position in the launch of lane l.
inline long position_of(const item_t *item, int l) {
  return POINTS == CELLS ? LANE_INT(item->positions, l) : item->first + l;
}

// Whether the points are rows of cells, four consecutive points each.
inline int has_rows(const item_t *item) {
  return LANES % 4 == 0 && POINTS == CELLS && ALL(item->mask);
}

// Stores the masked lanes of a plane.
inline void store_masked(__global float *plane, real value, const item_t *item) {
  if (!item->is_scattered) {
    store_plane(plane, value, item->count, item->first);
    return;
  }
  if (has_rows(item)) {
    for (int l = 0; l < LANES; l += 4)
      vstore4(((float4 *)&value)[l / 4], 0, plane + LANE_INT(item->positions, l));
    return;
  }
  for (int l = 0; l < item->lanes; ++l)
    if (LANE_INT(item->mask, l)) plane[position_of(item, l)] = LANE(value, l);
}

// The same of interleaved points.
inline void store_masked_points(__global float *points, vec value, const item_t *item) {
  if (!item->is_scattered) {
    store_interleaved(points + 3 * item->first, value, item->lanes);
    return;
  }
  if (has_rows(item)) {
    real interleaved[3];
    set_interleaved(interleaved, value);
    for (int l = 0; l < LANES; l += 4)
      for (int n = 0; n < 3; ++n)
        vstore4(((float4 *)interleaved)[3 * (l / 4) + n], n, points + 3 * LANE_INT(item->positions, l));
    return;
  }
  for (int l = 0; l < item->lanes; ++l)
    if (LANE_INT(item->mask, l)) store_point(points + 3 * position_of(item, l), value, l);
}

// Stores the void distance (cuts.cl) in world units, `scale` times the local one. The second pass
// masks points where it is not larger.
inline void store_void_distance(item_t *item, const map_t *map, const fit_t *fit,
                                __global float *void_distance, float scale) {
  if (!CUTS) return;
  real distance = scale * void_distance_at(map, fit, map_displacement(map, fit));
  if (is_second_pass(&map->cuts)) {
    item->mask &= distance > load_plane(void_distance, item->count, item->first);
    item->is_scattered |= !ALL(item->mask);
  }
  store_masked(void_distance, distance, item);
}

// The fit at the points of a work item.
inline fit_t fit_on_grid(const map_t *map, const grid_t *grid, const item_t *item,
                         const nodes_t *nodes, __global const node_t *node_table) {
  return fit_from_nodes(map, nodes, node_table, item->index, transformed(grid->frame, item->index));
}
