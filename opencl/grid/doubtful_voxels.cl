// Finds the voxels of a displacement field in which the field may fold, by the volumes of six tetrahedra
// each (vtk_mls/queries/certificate.py).

#include "types.cl"

#if LANES > 1
// The float of component n / LANES of lane n % LANES, in two shuffles of three vectors.
#define SOURCE_OF(n) (3 * ((n) % LANES) + (n) / LANES)
#define IN_FIRST_TWO(n) (SOURCE_OF(n) < 2 * LANES ? SOURCE_OF(n) : -1)
#define OR_IN_THIRD(n) (SOURCE_OF(n) < 2 * LANES ? (n) % LANES : SOURCE_OF(n) - LANES)
#define HALVES(a, b, i, j, k, l) \
  __builtin_shufflevector(a, b, i, j, k, l, i + 4, j + 4, k + 4, l + 4)
#define COMPONENT(a, b, c, n)                                                          \
  __builtin_shufflevector(__builtin_shufflevector(a, b, EACH_LANE(IN_FIRST_TWO, n)), c, \
                          EACH_LANE(OR_IN_THIRD, n))
#endif

// Displacements of LANES points of a row from x on; the last of the row is repeated.
HOT vec load_displacements(__global const float *row, int x, int count) {
  vec d;
#if LANES > 1
  if (x + LANES <= count) {
    __global const float *from = row + 3 * x;
#if LANES == 8
    // Shuffles within halves are one instruction each.
    const real a = (real)(vload4(0, from), vload4(3, from)), b = (real)(vload4(1, from), vload4(4, from)),
               c = (real)(vload4(2, from), vload4(5, from));
    d.x = HALVES(a, HALVES(b, c, 2, 2, 9, 9), 0, 3, 8, 10);
    d.y = HALVES(HALVES(a, b, 1, 1, 8, 8), HALVES(b, c, 3, 3, 10, 10), 0, 2, 8, 10);
    d.z = HALVES(HALVES(a, b, 2, 2, 9, 9), c, 0, 2, 8, 11);
#else
    const real a = LOAD(from), b = LOAD(from + LANES), c = LOAD(from + 2 * LANES);
    d.x = COMPONENT(a, b, c, 0);
    d.y = COMPONENT(a, b, c, LANES);
    d.z = COMPONENT(a, b, c, 2 * LANES);
#endif
    return d;
  }
#endif
  for (int l = 0; l < LANES; ++l) {
    __global const float *from = row + 3 * min(x + l, count - 1);
    LANE(d.x, l) = from[0];
    LANE(d.y, l) = from[1];
    LANE(d.z, l) = from[2];
  }
  return d;
}

// The deformed edge from a point to the next along an axis.
HOT vec edge(vec from, vec to, const float *axis) {
  const vec a = {axis[0], axis[1], axis[2]};
  return vec_add(vec_sub(to, from), a);
}

// A row of voxels: displacements of the points x, and the edges from these to the points x + 1.
typedef struct { vec displacement, edge; } row_t;

HOT row_t load_row(const voxels_t *voxels, __global const float *row, int x) {
  const vec from = load_displacements(row, x, voxels->size[0]);
  __global const float *last = row + 3 * min(x + LANES, voxels->size[0] - 1);
  const vec to = {LANES_AFTER(from.x, last[0]), LANES_AFTER(from.y, last[1]),
                  LANES_AFTER(from.z, last[2])};
  return (row_t){from, edge(from, to, voxels->axes)};
}

// Whether the smallest volume of six tetrahedra is not above `share` of their sum, relative to the
// undeformed volume; also for NaN. Each lies between two neighbors of x, xy, y, yz, z and xz, around the
// diagonal. `next_z` is the edge z of the next row.
HOT integer is_doubtful(const voxels_t *voxels, vec x, vec y, vec z, vec next_x, vec upper_x, vec next_z,
                        vec next_upper_x) {
  const vec xy = vec_add(y, next_x), xz = vec_add(z, upper_x), yz = vec_add(y, next_z);
  const vec diagonal = vec_scale(voxels->inverse_volume, vec_add(yz, next_upper_x));
  const vec by_x = cross3(diagonal, x), by_y = cross3(diagonal, y), by_z = cross3(diagonal, z);
  const real volumes[6] = {dot3(by_x, xy),  -dot3(by_y, xy), dot3(by_y, yz),
                           -dot3(by_z, yz), dot3(by_z, xz),  -dot3(by_x, xz)};
  real smallest = volumes[0], sum = volumes[0];
  UNROLL_ALL for (int i = 1; i < 6; ++i) {
    smallest = fast_min(smallest, volumes[i]);
    sum += volumes[i];
  }
  return !(smallest > voxels->share * sum);
}

// Writes 1 for each doubtful voxel, and 0 for the others. A work item computes LANES voxels along x in
// VOXEL_ROWS rows; the last of a row begin so that they end with it.
__kernel EXPLICIT_VECTORS void doubtful_voxels(
    const voxels_t voxels, __global const float *restrict displacement,
    __global uchar *restrict result) {
  const int nx = voxels.size[0] - 1, ny = voxels.size[1] - 1, nz = voxels.size[2] - 1;
  const int strips = (nx + LANES - 1) / LANES, stacks = (ny + VOXEL_ROWS - 1) / VOXEL_ROWS;
  const long item = get_global_id(0);
  const int x = max(min((int)(item % strips) * LANES, nx - LANES), 0);
  const int begin = (int)(item / strips % stacks) * VOXEL_ROWS, end = min(begin + VOXEL_ROWS, ny);
  const int z = (int)(item / strips / stacks);
  if (z >= nz) return;
  const long row = 3L * voxels.size[0], layer = row * voxels.size[1];
  __global const float *from = displacement + row * begin + layer * z;
  __global uchar *to = result + x + nx * (begin + (long)ny * z);
  row_t lower = load_row(&voxels, from, x), upper = load_row(&voxels, from + layer, x);
  vec along_z = edge(lower.displacement, upper.displacement, voxels.axes + 6);
  for (int y = begin; y < end; ++y, to += nx) {
    from += row;
    for (int c = 0; c < 3; ++c) FETCH(from + 2 * row + layer + 3 * x + c * LANES);
    const row_t next = load_row(&voxels, from, x), next_upper = load_row(&voxels, from + layer, x);
    const vec next_z = edge(next.displacement, next_upper.displacement, voxels.axes + 6);
    const integer doubtful = is_doubtful(
        &voxels, lower.edge, edge(lower.displacement, next.displacement, voxels.axes + 3), along_z,
        next.edge, upper.edge, next_z, next_upper.edge);
    lower = next;
    upper = next_upper;
    along_z = next_z;
    if (nx >= LANES)
      STORE_FLAGS(doubtful, to);
    else
      for (int l = 0; l < nx; ++l) to[l] = (uchar)(LANE_INT(doubtful, l) & 1);
  }
}
