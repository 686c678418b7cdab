// Points of a regular grid, numbered with x fastest.

#ifndef GRID
#error "GRID is missing: members of the struct below"
#endif

// The points `first` to `stop` of this launch; the grid's size `nx`, `ny`; `start`, the index of
// its first point in the whole grid; `frame` takes indices of the whole grid to the local frame.
typedef struct { GRID } grid_t;

// Indices (i, j, k) in the whole grid of the points n, n + 1, ... n + LANES - 1.
inline vec grid_index(const grid_t *grid, long n) {
  long row = n / grid->nx;
  integer i, j = (int)(row % grid->ny), k = (int)(row / grid->ny);
  for (int l = 0; l < LANES; ++l) LANE_INT(i, l) = (int)(n % grid->nx) + l;
  while (ANY(i >= grid->nx)) {
    integer over = i >= grid->nx;
    i = select(i, i - grid->nx, over);
    j = select(j, j + 1, over);
    over = j >= grid->ny;
    j = select(j, j - grid->ny, over);
    k = select(k, k + 1, over);
  }
  return (vec){TO_REAL(i + grid->start[0]), TO_REAL(j + grid->start[1]),
               TO_REAL(k + grid->start[2])};
}
