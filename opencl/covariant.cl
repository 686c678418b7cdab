// Gradients and normals, which are covariant, under the map that moved them. Build constants:
// README.md.

#include "types.cl"

// J^T n (Eq. 29) in place of each of `count` vectors n, interleaved; of length 1 (or 0) if
// `normalise`. `source` is what `grid_source_frame` stores: after three planes nine of J = dG/dv.
KERNEL void covariant(const long count, __global const float *restrict source, const int normalise,
                 __global float *restrict vectors) {
  long first = (long)get_global_id(0) * LANES;
  if (first >= count) return;
  int lanes = (int)min((long)LANES, count - first);
  __global float *to = vectors + 3 * first;
  mat j;
  for (int i = 0; i < 9; ++i) j.a[i] = load_plane(source + (3 + i) * count, count, first);
  vec n = {0, 0, 0};
  for (int l = 0; l < lanes; ++l) {
    LANE(n.x, l) = to[3 * l];
    LANE(n.y, l) = to[3 * l + 1];
    LANE(n.z, l) = to[3 * l + 2];
  }
  n = transposed_mat_vec(&j, n);
  if (normalise) n = unit3(n);
  store_interleaved(to, n, lanes);
}
