// No cuts: each control point is seen from everywhere, and nothing is void. See cuts.cl.

#define UNREACHABLE 1e29f
// Distances from regions are cached.
#define CACHED_BY_CUTS (REGIONS ? 16 : 0)
#define PLANES 3

typedef struct { char none; } cuts_t;
typedef struct { integer crossed_cuts; } view_t;

inline cuts_t cuts_of(const cut_params_t params, __global const plane_t *planes,
                      __global const float *obstacles) {
  return (cuts_t){0};
}

inline cuts_t cuts_of_step(const cuts_t *cuts, int k) { return *cuts; }

inline void set_view(const cuts_t *cuts, view_t *view, vec from) {}

inline void set_hiding(view_t *view, integer hides_any) {}

inline integer is_unreachable(real d2) { return 0; }

inline real damped_distance2(const cuts_t *cuts, const view_t *view, int k, vec q, real d2,
                             integer *hides_any) {
  return d2;
}

inline vec damping_slope(const cuts_t *cuts, const view_t *view, int k, vec q) {
  return (vec){0, 0, 0};
}

inline vec mean_displacement_of(const cuts_t *cuts) { return (vec){0, 0, 0}; }

inline vec origin_of(const cuts_t *cuts, vec v, vec d) { return vec_add(v, d); }

inline integer in_region(const cuts_t *cuts, vec index) { return (real)(0) == 0; }

inline integer may_be_in_region(const cuts_t *cuts, vec index, int step) {
  return (real)(0) == 0;
}

inline integer on_side(const cuts_t *cuts, vec x, real size) { return (real)(0) == 0; }

inline integer blocked(const cuts_t *cuts, vec v, vec g) { return 0; }

inline real void_distance_of(const cuts_t *cuts, vec v, vec g, integer crossed_cuts) {
  return FLT_MAX;
}

inline int regions_compete(const cuts_t *cuts) { return 0; }
inline int is_second_pass(const cuts_t *cuts) { return 0; }
