// The lattice of first guesses for the inverse. It depends on the deformation only, so that a point has
// the same guess in every call.
//
// Level 0 is a box around the control points, each further level a box twice as large around the
// same center. All have LATTICE_CELLS cells along each axis; a point is in the smallest box that
// holds it. Cells are numbered along x, then y, then z, level by level.

enum {
  LEVEL_SIZE = LATTICE_CELLS * LATTICE_CELLS * LATTICE_CELLS,
  LATTICE_SIZE = LATTICE_LEVELS * LEVEL_SIZE,
  NODES_ALONG = LATTICE_CELLS + 1
};

// Cell index along one axis, and the relative position in that cell, for a position in [-1, 1].
inline integer cell_along(real position, real *share) {
  real index = (position + 1) * (0.5f * LATTICE_CELLS);
  index = fast_min(fast_max(index, (real)(0)), (real)(LATTICE_CELLS));
  integer cell = TO_INTEGER(fast_min(index, (real)(LATTICE_CELLS - 1)));
  *share = index - TO_REAL(cell);
  return cell;
}

// The cell of a local point, and the relative position in it; LATTICE_SIZE or more beyond all levels.
// `shrink` is the ratio of the cell sizes of level 0 and of the point's level, `node` the number of the
// first node of the cell.
inline integer lattice_cell(const lattice_t *lattice, vec x, vec *share, real *shrink,
                            integer *node) {
  const float *center = lattice->center, *density = lattice->density;
  vec at = {(x.x - center[0]) * density[0], (x.y - center[1]) * density[1],
            (x.z - center[2]) * density[2]};
  real distance = fast_max(fast_max(fabs(at.x), fabs(at.y)), fabs(at.z));
  integer level = 0;
  *shrink = 1;
  for (int l = 0; l < LATTICE_LEVELS; ++l) {
    integer beyond = distance > (real)(1 << l);
    level = select(level, (integer)(l + 1), beyond);
    *shrink = select(*shrink, 0.5f * *shrink, beyond);
  }
  integer i = cell_along(*shrink * at.x, &share->x), j = cell_along(*shrink * at.y, &share->y),
          k = cell_along(*shrink * at.z, &share->z);
  *node = i + NODES_ALONG * (j + NODES_ALONG * (k + NODES_ALONG * level));
  return i + LATTICE_CELLS * (j + LATTICE_CELLS * (k + LATTICE_CELLS * level));
}
