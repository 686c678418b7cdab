#include "source_index.cl"

// The same, and the Jacobian for a gradient there: after the indices follow nine planes of dG/dv.
// With cuts also the void distance, local units times `scale`.
KERNEL void grid_source_frame(MAP_PARAMETERS, GRID_PARAMETERS, SOURCE_PARAMETERS
#if CUTS
                              , const float scale, __global float *restrict void_distance
#endif
) {
  FIT_ON_GRID
  STORE_SOURCE_INDEX
  const mat j = moved_jacobian(&map, &fit);
  for (int i = 0; i < 9; ++i) {
    const real entry = j.a[i] + (i % 4 == 0 ? 1.0f : 0.0f);
    STORE_KEPT(index + (3 + i) * count, entry)
  }
#if CUTS
  const real nothing = scale * VOID_DISTANCE;
  STORE_KEPT(void_distance, nothing)
#endif
}
