// No curves. The structs and functions are those of segments.cl; none is called.

#define SEGMENT_POINTS 1
#define CACHED_SEGMENTS 0
#define TOP 2
#define MOMENTS 4
#define ON_CURVE 0
#define INTEGER_ALPHA 1

typedef struct { real projection[1], off2[1]; } cached_segments_t;
typedef struct { real projection, t, off2, d2; } nearest_t;
typedef struct { real t[SEGMENT_POINTS], w[SEGMENT_POINTS]; } rule_t;
typedef struct { real l[SEGMENT_POINTS][SEGMENT_POINTS], norm[SEGMENT_POINTS]; } factors_t;

inline nearest_t nearest_by_projection(__global const segment_t *at, real projection, real off2) {
  return (nearest_t){0, 0, 0, 0};
}

inline nearest_t nearest_on_segment(__global const segment_t *at, vec v) {
  return (nearest_t){0, 0, 0, 0};
}

inline real whole_power(real x, int n) { return x; }

inline real weight_moments(__global const segment_t *at, const nearest_t *nearest, float smoothing2,
                           real e2, int slopes, int top, real c, real m[MOMENTS]) {
  return 0;
}

inline rule_t rule_of(const real m[MOMENTS], int skewed) { return (rule_t){{0}, {0}}; }

inline factors_t factors_of(const real *m) { return (factors_t){{{0}}, {0}}; }
