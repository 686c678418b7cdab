#include "inverse.cl"

// Whether a cut separates x from a sample of the map, in the frame of the cuts.
inline integer is_separated(const map_t *map, vec x, vec image, vec displacement) {
  if (!AT_REST) return is_blocked(map, x, displacement);
  const vec none = {0, 0, 0};
  return blocked(&map->cuts, origin_of(&map->cuts, x, none), origin_of(&map->cuts, image, none));
}

// For points x less the mean displacement the displacement to the sample of the map whose image is
// nearest, in three planes. Samples with images no farther than `min_distances2` are skipped; these
// become the distances of the images.
__kernel EXPLICIT_VECTORS void nearest_sample(
    MAP_ARGUMENTS, POINT_ARGUMENTS, const int sample_count,
    __global const sample_t *restrict samples, __global float *restrict min_distances2,
    __global float *restrict displacements) {
  const map_t map = THE_MAP;
  long first = (long)get_global_id(0) * LANES;
  if (first >= points_count) return;
  vec x = load_points(points, points_count, first);
  const real min_distance2 = load_plane(min_distances2, points_count, first);
  real nearest = FLT_MAX;
  vec displacement = {0, 0, 0};
  for (int i = 0; i < sample_count; ++i) {
    __global const sample_t *at = samples + i;
    vec miss = vec_sub(x, load3(at->image));
    real d2 = dot3(miss, miss);
    integer nearer = (d2 < nearest) & (d2 > min_distance2);
    if (!ANY(nearer)) continue;
    vec to_sample = vec_sub(load3(at->v), x);
    nearer &= !is_separated(&map, x, vec_sub(x, miss), to_sample);
    displacement = vec_select(displacement, to_sample, nearer);
    nearest = select(nearest, d2, nearer);
  }
  store_points(displacements, displacement, points_count, first);
  store_plane(min_distances2, nearest, points_count, first);
}
