// Points of a regular grid, numbered with x fastest.

typedef struct {
  long first, stop;  // the points of this launch
  int nx, ny;
  int4 start;        // index of the first point in the whole grid
} grid_t;

// `frame` takes indices of the whole grid to the local frame.
#define GRID_PARAMETERS                                                       \
  const long grid_first, const long grid_stop, const int nx, const int ny, \
      const int4 grid_start, const float16 frame
#define GRID \
  { grid_first, grid_stop, nx, ny, grid_start }

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
  int4 start = grid->start;
  return (vec){TO_REAL(i + start.x), TO_REAL(j + start.y), TO_REAL(k + start.z)};
}

// An affine transform t: columns for x, y, z, then the offset, three numbers each.
inline vec transformed(const float16 t, vec x) {
  return (vec){fma((real)(t.s0), x.x, fma((real)(t.s3), x.y, fma((real)(t.s6), x.z, (real)(t.s9)))),
               fma((real)(t.s1), x.x, fma((real)(t.s4), x.y, fma((real)(t.s7), x.z, (real)(t.sa)))),
               fma((real)(t.s2), x.x, fma((real)(t.s5), x.y, fma((real)(t.s8), x.z, (real)(t.sb))))};
}
