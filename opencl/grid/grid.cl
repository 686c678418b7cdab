// Points of a regular grid, numbered with x fastest.

// Indices (i, j, k) in the whole grid of LANES of `count` listed points, from entry `at` on; the last
// entry is repeated.
inline vec listed_index(const grid_t *grid, __global const long *listed, long count, long at) {
  integer i, j, k;
  for (int l = 0; l < LANES; ++l) {
    const long n = listed[min(at + l, count - 1)], row = n / grid->nx;
    LANE_INT(i, l) = (int)(n % grid->nx);
    LANE_INT(j, l) = (int)(row % grid->ny);
    LANE_INT(k, l) = (int)(row / grid->ny);
  }
  return (vec){TO_REAL(i + grid->start[0]), TO_REAL(j + grid->start[1]),
               TO_REAL(k + grid->start[2])};
}

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
