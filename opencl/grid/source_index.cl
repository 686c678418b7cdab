// Source indices of the points of a grid: where their material comes from, and where covariant vectors are
// sampled.
//
// Build constants: VECTOR_FILE, a file of the feature or of its absence.

#include "on_grid.cl"
#include VECTOR_FILE

// Arguments of the kernels: three planes of source indices, and void distances unless null, `scale` times
// the local ones; with vectors n of an array, J^T n(G(v)) (Eq. 29), of length 1 (or 0) if `normalize`.
#define SOURCE_ARGUMENTS                                                        \
  const source_t source, __global float *restrict index,                        \
      __global float *restrict void_distance, const float scale,                \
      const array_t array, const int normalize,                                 \
      __global const float *restrict vectors, __global float *restrict covariant

// Continuous source indices of the target indices `index`, for local displacements d; outside of any source
// where points are void.
inline vec source_index_of(const source_t *source, vec index, vec d, integer is_void) {
  vec from = vec_add(transformed(source->from_target, index), transformed(source->from_displacement, d));
  from.x = select(from.x, (real)(-1e9f), is_void);
  return from;
}
