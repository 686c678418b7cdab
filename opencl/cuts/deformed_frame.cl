// Cuts that stay, and maps without cuts: the fit at a point is found at once. See rest_frame.cl.

inline fit_t fit_at(const map_t *map, vec v) {
  fit_t fit;
  set_point(&map->cuts, &fit.point, v, v);
  fit_map(map, &fit);
  return fit;
}

// The fit at a point of a grid, without the nodes from which searches start.
inline fit_t fit_from_nodes(const map_t *map, const nodes_t *nodes, __global const node_t *table,
                            vec index, vec v) {
  return fit_at(map, v);
}

// Stores displacements at points in planes; void distances, too, if regions compete or there are several
// steps. `starts` is null.
inline void displace_points(const map_t *map, long count, __global const float *points,
                            __global const float *starts, __global float *displacement) {
  const long first = (long)get_global_id(0) * LANES;
  if (first >= count) return;
  const fit_t fit = fit_at(map, load_points(points, count, first));
  const vec d = map_displacement(map, &fit);
  store_points(displacement, d, count, first);
  if (CUTS && (STEPS || regions_compete(&map->cuts)))
    store_plane(displacement + 3 * count, void_distance_at(map, &fit, d), count, first);
}

inline mat map_jacobian(const map_t *map, const fit_t *fit) {
  return material_jacobian(map, fit);
}
