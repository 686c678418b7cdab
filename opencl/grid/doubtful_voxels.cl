// Finds the voxels of a displacement field in which the field may fold, by the volumes of six tetrahedra
// each (vtk_mls/queries/certificate.py).

#include "types.cl"

#if LANES > 1
// The float of component n / LANES of lane n % LANES, in two shuffles of three vectors.
#define SOURCE_OF(n) (3 * ((n) % LANES) + (n) / LANES)
#define IN_FIRST_TWO(n) (SOURCE_OF(n) < 2 * LANES ? SOURCE_OF(n) : -1)
#define OR_IN_THIRD(n) (SOURCE_OF(n) < 2 * LANES ? (n) % LANES : SOURCE_OF(n) - LANES)
#define COMPONENT(a, b, c, n)                                                          \
  __builtin_shufflevector(__builtin_shufflevector(a, b, EACH_LANE(IN_FIRST_TWO, n)), c, \
                          EACH_LANE(OR_IN_THIRD, n))
#endif

// Displacements of LANES points of a row from x on; the last is repeated.
HOT vec load_displacements(__global const float *row, int x, int count) {
  vec d;
#if LANES > 1
  if (x + LANES <= count) {
    __global const float *from = row + 3 * x;
    const real a = LOAD(from), b = LOAD(from + LANES), c = LOAD(from + 2 * LANES);
    d.x = COMPONENT(a, b, c, 0);
    d.y = COMPONENT(a, b, c, LANES);
    d.z = COMPONENT(a, b, c, 2 * LANES);
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

// Positions of the points x and x + 1 of a row of voxels, relative to the undeformed point x.
typedef struct { vec at[2]; } row_t;

HOT row_t load_row(const voxels_t *voxels, __global const float *row, int x) {
  const vec step = {voxels->axes[0], voxels->axes[1], voxels->axes[2]};
  row_t points;
  points.at[0] = vec_scale(voxels->density, load_displacements(row, x, voxels->size[0]));
  points.at[1] =
      vec_madd(voxels->density, load_displacements(row, x + 1, voxels->size[0]), step);
  return points;
}

typedef struct { real smallest, sum; } volumes_t;

// Adds a tetrahedron between the edges a and b around the diagonal.
HOT void add_volume(volumes_t *volumes, vec diagonal, vec a, vec b) {
  const real volume = dot3(diagonal, cross3(a, b));
  volumes->smallest = fast_min(volumes->smallest, volume);
  volumes->sum += volume;
}

// Whether the smallest of the six volumes is not above `share` of their sum; also for NaN. The rows are
// at y and y + 1 (`next`) of the lower and the upper layer.
HOT integer is_doubtful(const voxels_t *voxels, const row_t *lower, const row_t *next_lower,
                        const row_t *upper, const row_t *next_upper) {
  const float *a = voxels->axes;
  const vec from = lower->at[0];  // and as it is seen from the other rows
  const vec from_y = {from.x - a[3], from.y - a[4], from.z - a[5]};
  const vec from_z = {from.x - a[6], from.y - a[7], from.z - a[8]};
  const vec from_yz = {from_y.x - a[6], from_y.y - a[7], from_y.z - a[8]};
  const vec diagonal = vec_sub(next_upper->at[1], from_yz);
  const vec x = vec_sub(lower->at[1], from), xy = vec_sub(next_lower->at[1], from_y),
            y = vec_sub(next_lower->at[0], from_y), yz = vec_sub(next_upper->at[0], from_yz),
            z = vec_sub(upper->at[0], from_z), xz = vec_sub(upper->at[1], from_z);
  volumes_t volumes = {FLT_MAX, 0};
  add_volume(&volumes, diagonal, x, xy);
  add_volume(&volumes, diagonal, xy, y);
  add_volume(&volumes, diagonal, y, yz);
  add_volume(&volumes, diagonal, yz, z);
  add_volume(&volumes, diagonal, z, xz);
  add_volume(&volumes, diagonal, xz, x);
  return !(volumes.smallest > voxels->share * volumes.sum);
}

// Writes 1 for each doubtful voxel, and 0 for the others. A work item computes LANES voxels along x in
// VOXEL_ROWS rows.
__kernel EXPLICIT_VECTORS void doubtful_voxels(
    const voxels_t voxels, __global const float *restrict displacement,
    __global uchar *restrict result) {
  const int nx = voxels.size[0] - 1, ny = voxels.size[1] - 1, nz = voxels.size[2] - 1;
  const int strips = (nx + LANES - 1) / LANES, stacks = (ny + VOXEL_ROWS - 1) / VOXEL_ROWS;
  const long item = get_global_id(0);
  const int x = (int)(item % strips) * LANES, begin = (int)(item / strips % stacks) * VOXEL_ROWS;
  const int z = (int)(item / strips / stacks);
  if (z >= nz) return;
  const int lanes = min(LANES, nx - x), end = min(begin + VOXEL_ROWS, ny);
  const long row = 3L * voxels.size[0], layer = row * voxels.size[1];
  __global const float *from = displacement + row * begin + layer * z;
  row_t lower = load_row(&voxels, from, x), upper = load_row(&voxels, from + layer, x);
  for (int y = begin; y < end; ++y) {
    from += row;
    const row_t next_lower = load_row(&voxels, from, x), next_upper = load_row(&voxels, from + layer, x);
    const integer doubtful = is_doubtful(&voxels, &lower, &next_lower, &upper, &next_upper);
    lower = next_lower;
    upper = next_upper;
    __global uchar *to = result + x + nx * (y + (long)ny * z);
    for (int l = 0; l < lanes; ++l) to[l] = (uchar)(LANE_INT(doubtful, l) & 1);
  }
}
