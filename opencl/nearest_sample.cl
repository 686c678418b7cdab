#include "inverse.cl"

// For points x less the mean displacement the displacement to the best of some samples of the map, in
// three planes. Those that the map brings as near as `tried` (squared), or nearer, are left out.
KERNEL void nearest_sample(MAP_PARAMETERS, const long points_count,
                           __global const float *restrict points, const int sample_count,
                           __global const sample_t *restrict samples,
                           __global float *restrict tried,
                           __global float *restrict displacements) {
  const map_t map = MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first);
  real distance2 = load_plane(tried, points_count, first);
  vec displacement = displacement_to_nearest(&map, x, sample_count, samples, &distance2);
  store_points(displacements, displacement, points_count, first);
  store_plane(tried, distance2, points_count, first);
}
