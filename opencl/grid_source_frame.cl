#include "source_index.cl"

// The same, and what turns a gradient there: after the indices follow nine planes of dG/dv. With
// cuts also the opening, local units times `scale`.
KERNEL void grid_source_frame(MAP_PARAMETERS, LATTICE_PARAMETERS, SOURCE_PARAMETERS
#if CUTS
                              , const float scale, __global float *restrict opening
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
  const real open = scale * OPENING;
  STORE_KEPT(opening, open)
#endif
}
