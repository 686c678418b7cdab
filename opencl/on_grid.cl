// What the kernels over a grid share.

#include "map.cl"
#include "grid.cl"
#if AT_REST
#include "origin_nodes.cl"
#endif
#ifdef COARSE_STEP
#include "coarse_map.cl"
#endif

// The void distance of the points of a launch (cuts.cl), local units times `scale`.
//
// Full planes in the rest frame of cuts (RIVALS) make regions whose material may come to any point.
// First each region has the points where its own is expected; then, as a rival, those that are void
// so far, and keeps those whose void distance is larger with it.
typedef struct {
  __global float *at;
  float scale;
} void_distance_t;

#define VOID_PARAMETERS , __global float *restrict void_distance, const float scale
#define VOID_OF_LAUNCH ((void_distance_t){void_distance, scale})
#if RIVALS
#define RIVAL_PARAMETERS VOID_PARAMETERS
#define RIVALS_OF_LAUNCH VOID_OF_LAUNCH
#else
#define RIVAL_PARAMETERS
#define RIVALS_OF_LAUNCH ((void_distance_t){0, 0})
#endif

// Whether the launch may not have all points of a work item.
#if CUTS || defined(CELLS)
#define MAY_BE_LEFT 1
#else
#define MAY_BE_LEFT 0
#endif

// The points of a work item.
typedef struct {
  long at, count;  // the first of them, of how many in this launch
  int lanes;       // 0 where there is nothing to do
  vec index;       // in the whole grid
#if MAY_BE_LEFT
  integer kept;    // whether this launch has them
#endif
#ifdef CELLS
  integer to;      // where each of them is in the launch
#endif
} item_t;

#ifdef CELLS
#define CELL_POINTS (COARSE_STEP * COARSE_STEP * COARSE_STEP)

// Points of a cell, of which `cells` lists those of a launch.
inline item_t item_of(const map_t *map, const grid_t *grid, const coarse_t *coarse,
                      __global const int *cells) {
  const long first = (long)get_global_id(0) * LANES, number = first / CELL_POINTS;
  item_t item = {0, grid->stop - grid->first, 0};
  if (number >= coarse->listed) return item;
  const int cell = cells[coarse->first_listed + number], nx = coarse->cells[0];
  const int x = (coarse->first_cell[0] + cell % nx) * COARSE_STEP - grid->start[0],
            y = (coarse->first_cell[1] + cell / nx % coarse->cells[1]) * COARSE_STEP,
            z = (coarse->first_cell[2] + cell / nx / coarse->cells[1]) * COARSE_STEP;
  integer i, j, k;
  for (int l = 0; l < LANES; ++l) {
    const int point = (int)(first % CELL_POINTS) + l;
    const int a = x + point % COARSE_STEP,
              b = y - grid->start[1] + point / COARSE_STEP % COARSE_STEP,
              c = z - grid->start[2] + point / COARSE_STEP / COARSE_STEP;
    const long to = a + grid->nx * (b + (long)grid->ny * c) - grid->first;
    LANE_INT(item.kept, l) =
        a >= 0 && a < grid->nx && b >= 0 && b < grid->ny && c >= 0 && to >= 0 && to < item.count
            ? -1 : 0;
    LANE_INT(item.to, l) = (int)to;
    LANE_INT(i, l) = a + grid->start[0];
    LANE_INT(j, l) = b + grid->start[1];
    LANE_INT(k, l) = c + grid->start[2];
  }
  item.index = (vec){TO_REAL(i), TO_REAL(j), TO_REAL(k)};
#if CUTS
  item.kept &= in_region(&map->cuts, item.index);
#endif
  item.lanes = ANY(item.kept) ? LANES : 0;
  return item;
}

#define ITEM_PARAMETERS , const coarse_t coarse, __global const int *restrict cells
#define ITEM_OF_LAUNCH(map, grid) item_of(map, grid, &coarse, cells)
#else
#ifdef LISTED
#define ITEM_PARAMETERS , __global const long *restrict numbers
#define ITEM_OF_LAUNCH(map, grid) item_of(map, grid, numbers, RIVALS_OF_LAUNCH)
#else
#define ITEM_PARAMETERS
#define ITEM_OF_LAUNCH(map, grid) item_of(map, grid, 0, RIVALS_OF_LAUNCH)
#endif

inline item_t item_of(const map_t *map, const grid_t *grid, __global const long *numbers,
                      void_distance_t rivals) {
  item_t item;
  item.at = (long)get_global_id(0) * LANES;
  item.count = grid->stop - grid->first;
  item.lanes = (int)clamp(item.count - item.at, (long)0, (long)LANES);
  if (item.lanes == 0) return item;
#ifdef LISTED
  item.index = listed_index(grid, numbers, item.count, item.at);
#else
  item.index = grid_index(grid, grid->first + item.at);
#endif
#if CUTS
  item.kept = in_region(&map->cuts, item.index);
#if RIVALS
  if (map->cuts.numbers.is_rival)
    item.kept = !item.kept & (load_plane(rivals.at, item.count, item.at) < 0);
#endif
  if (!ANY(item.kept)) item.lanes = 0;
#endif
  return item;
}
#endif

// Where in the launch lane l is.
inline long position_of(const item_t *item, int l) {
#ifdef CELLS
  return LANE_INT(item->to, l);
#else
  return item->at + l;
#endif
}

// Whether lane l belongs to this launch.
inline int is_kept(const item_t *item, int l) {
#if MAY_BE_LEFT
  return LANE_INT(item->kept, l);
#else
  return 1;
#endif
}

// Whether they are not all one behind the other, or do not all belong to this launch.
inline int is_scattered(const item_t *item) {
#ifdef CELLS
  return 1;
#elif CUTS
  return !ALL(item->kept);
#else
  return 0;
#endif
}

// Stores the lanes of a plane that belong to this launch.
inline void store_kept(__global float *plane, real value, const item_t *item) {
  if (is_scattered(item)) {
    for (int l = 0; l < item->lanes; ++l)
      if (is_kept(item, l)) plane[position_of(item, l)] = LANE(value, l);
    return;
  }
  store_plane(plane, value, item->count, item->at);
}

// The same of interleaved points.
inline void store_kept_points(__global float *points, vec value, const item_t *item) {
  if (!is_scattered(item)) {
    store_interleaved(points + 3 * item->at, value, item->lanes);
    return;
  }
  for (int l = 0; l < item->lanes; ++l)
    if (is_kept(item, l)) store_point(points + 3 * position_of(item, l), value, l);
}

#if CUTS
// Stores the void distance; a rival keeps only the points where its own is larger.
inline void store_void_distance(item_t *item, const map_t *map, const fit_t *fit,
                                void_distance_t to) {
  real here = to.scale * void_distance_at(map, fit, moved(map, fit));
#if RIVALS && !defined(CELLS)
  if (map->cuts.numbers.is_rival)
    item->kept &= here > load_plane(to.at, item->count, item->at);
#endif
  store_kept(to.at, here, item);
}
#endif

#if RIVALS
#define STORE_RIVALS(item, map, fit) store_void_distance(item, map, fit, RIVALS_OF_LAUNCH)
#else
#define STORE_RIVALS(item, map, fit)
#endif

// The fit at the points of a work item.
#if AT_REST
#define NODE_PARAMETERS , const nodes_t nodes, __global const node_t *restrict node_table
#define NODES_OF_LAUNCH , &nodes, node_table

inline fit_t fit_on_grid(const map_t *map, const grid_t *grid, const item_t *item,
                         const nodes_t *nodes, __global const node_t *table) {
  vec v = transformed(grid->frame, item->index);
  return fit_from(map, v, start_at(map, nodes, table, item->index, v));
}
#else
#define NODE_PARAMETERS
#define NODES_OF_LAUNCH

inline fit_t fit_on_grid(const map_t *map, const grid_t *grid, const item_t *item) {
  return fit_at(map, transformed(grid->frame, item->index));
}
#endif
