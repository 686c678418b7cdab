#include "map.cl"

// d(G - v)/dv in nine planes, for material that is known to come from `origins`; only with cuts in the
// rest frame, which then see from there.
KERNEL void origin_jacobian(MAP_PARAMETERS, const long points_count,
                            __global const float *restrict points,
                            __global const float *restrict origins,
                            __global float *restrict jacobian) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  fit_t fit;
  look(&map.cuts, &fit.view, load_points(points, points_count, first),
       load_points(origins, points_count, first));
  fit_view(&map, &fit);
  mat j = moved_jacobian(&map, &fit);
  for (int i = 0; i < 9; ++i) store_plane(jacobian + i * points_count, j.a[i], points_count, first);
}
