// No rigid regions: see regions.cl.

typedef struct { real square; vec outward; } region_distance_t;

inline region_distance_t distance_from_region(__global const region_t *region,
                                              __global const float *images, vec v,
                                              const int with_outward) {
  return (region_distance_t){0, {0, 0, 0}};
}
