// Cuts that stay, and maps without cuts: the fit at a point is found at once. See rest_frame.cl.

inline fit_t fit_at(const map_t *map, vec v) {
  fit_t fit;
  set_point(&map->cuts, &fit.point, v, v);
  fit_map(map, &fit);
  return fit;
}

inline mat map_jacobian(const map_t *map, const fit_t *fit) {
  return material_jacobian(map, fit);
}
