#include "inverse.cl"

// For points x less the mean displacement the displacement to the sample of the map whose image is
// nearest, in three planes. Samples with images no farther than `min_distances2` are skipped.
__kernel EXPLICIT_VECTORS void nearest_sample(
    MAP_ARGUMENTS, POINT_ARGUMENTS, const int sample_count,
    __global const sample_t *restrict samples, __global float *restrict min_distances2,
    __global float *restrict displacements) {
  const map_t map = THE_MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first);
  real min_distance2 = load_plane(min_distances2, points_count, first);
  vec displacement = displacement_to_nearest(&map, x, sample_count, samples, &min_distance2);
  store_points(displacements, displacement, points_count, first);
  store_plane(min_distances2, min_distance2, points_count, first);
}
