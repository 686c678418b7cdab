// A map of one step: see steps.cl.

inline map_t step_of(const map_t *map, int k) { return *map; }

inline void fit_map(const map_t *map, fit_t *fit) { fit_step(map, fit); }

inline vec start_of(const fit_t *fit) { return fit->point.v; }

// G(v) - v - mean displacement.
inline vec map_displacement(const map_t *map, const fit_t *fit) {
  return step_displacement(map, fit);
}

inline weight_jacobian_t composed_jacobian(const map_t *map, const fit_t *fit, real *determinant) {
  const weight_jacobian_t jacobian = step_jacobian(map, fit);
  *determinant = determinant_of(&jacobian.d_dv);
  return jacobian;
}
