// No masks and faces: see limits.cl.

inline vec limited(const map_t *map, vec v, vec d) { return d; }

inline weight_jacobian_t limited_jacobian(const map_t *map, vec v, vec d,
                                          weight_jacobian_t jacobian) {
  return jacobian;
}
