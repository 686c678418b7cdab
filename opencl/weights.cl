// The weights of Eq. 2 and 27: c_i / |q_i - v|^(2 alpha), for every power and distance in float32.
//
// Behind a cut a control point is as far away as its damped weight makes it: all distances here are
// such distances. k is the control point nearest to v, e the distance of the second nearest. All other control
// points are summed with weights (e / d_i)^(2 alpha) <= 1, which neither vanish nor overflow; the
// share r = (d_k / e)^(2 alpha) relates them to the weight of k. Coordinates are relative to k, so
// k itself adds to no sum but the total weight, and r = 0 (v on a control point) is exact.

// A control point in memory: q (3), c, p - q - drift (3), 0.
#define HANDLE_SIZE 8

typedef struct {
  int count;                      // control points
  float alpha;
  int rotation_rank;              // 0: none, 1: all but the twist about a line, 2: whole
  float4 flip_axis;               // normal to the line of rank 1
  int functions;                  // that the control points can tell, of FUNCTIONS
  __global const float *handles;  // (count, HANDLE_SIZE)
  __global const float *values;   // (count, FUNCTIONS), basis functions at the control points
  __global const float *coefficients;  // (FUNCTIONS, MONOMIALS)
#if CUTS
  cuts_t cuts;
#endif
} map_t;

#define MAP_PARAMETERS                                                                       \
  const int handle_count, const float alpha, const int rotation_rank, const float4 flip_axis, \
      const int functions, __global const float *restrict handles,                           \
      __global const float *restrict values,                                                 \
      __global const float *restrict coefficients CUT_PARAMETERS
#define MAP                                                                          \
  {                                                                                  \
    handle_count, alpha, rotation_rank, flip_axis, functions, handles, values, coefficients \
    CUTS_OF_LAUNCH                                                                   \
  }

#if !CUTS
#define CUT_PARAMETERS
#define CUTS_OF_LAUNCH
typedef struct { vec v; } view_t;
#define KNOWN 0
#endif

inline view_t view_at(const map_t *map, vec v) {
#if CUTS
  return view_of(&map->cuts, v);
#else
  return (view_t){v};
#endif
}

// Control points are summed in blocks, and the blocks in turn: rounding grows with the fourth root
// of their number.
inline int block_of(const map_t *map) { return max(16, (int)sqrt((float)map->count)); }

// What all sums at v are relative to.
typedef struct {
  integer k;  // nearest control point
  vec q;      // q_k
  vec x;      // v - q_k
  vec u;      // p_k - q_k - drift
  real c;     // its weight factor
  real d2;    // |x|^2
  real e2;    // squared distance of the second nearest
  real r;     // (d_k / e)^(2 alpha)
} pivot_t;

inline real straight_distance2(__global const float *handle, vec v) {
  real dx = handle[0] - v.x, dy = handle[1] - v.y, dz = handle[2] - v.z;
  return fma(dx, dx, fma(dy, dy, dz * dz));
}

inline real handle_distance2(const map_t *map, int i, const view_t *view) {
  __global const float *handle = map->handles + (long)i * HANDLE_SIZE;
  real d2 = straight_distance2(handle, view->v);
#if CUTS
  vec q = {handle[0], handle[1], handle[2]};
  d2 = damped_distance2(&map->cuts, view, i, q, d2);
#endif
  return d2;
}

inline pivot_t find_pivot(const map_t *map, view_t *view) {
  real first = FLT_MAX, second = FLT_MAX;
  integer k = 0;
  for (int i = 0; i < map->count; ++i) {
    real d2 = handle_distance2(map, i, view);
    integer nearer = d2 < first;
    second = least(second, most(first, d2));
    first = least(first, d2);
    k = select(k, (integer)(i), nearer);
#if KNOWN
    if (i < KNOWN) view->known[i] = d2;
#endif
  }
  pivot_t pivot;
  pivot.k = k;
  __global const float *nearest = map->handles + (long)LANE_INT(k, 0) * HANDLE_SIZE;
  pivot.q = (vec){nearest[0], nearest[1], nearest[2]};
  pivot.c = nearest[3];
  pivot.u = (vec){nearest[4], nearest[5], nearest[6]};
  if (ANY(k != LANE_INT(k, 0)))  // neighbours mostly share their nearest control point
    for (int l = 1; l < LANES; ++l) {
      nearest = map->handles + (long)LANE_INT(k, l) * HANDLE_SIZE;
      LANE(pivot.q.x, l) = nearest[0];
      LANE(pivot.q.y, l) = nearest[1];
      LANE(pivot.q.z, l) = nearest[2];
      LANE(pivot.c, l) = nearest[3];
      LANE(pivot.u.x, l) = nearest[4];
      LANE(pivot.u.y, l) = nearest[5];
      LANE(pivot.u.z, l) = nearest[6];
    }
  pivot.x = vec_sub(view->v, pivot.q);
  pivot.d2 = first;
  pivot.e2 = most(second, 1e-30f);
  pivot.r = power(first / pivot.e2, map->alpha);
  return pivot;
}

// Weight of a control point next to the others but k.
inline real handle_weight(const map_t *map, int i, const pivot_t *pivot, const view_t *view) {
#if KNOWN
  real d2 = i < KNOWN ? view->known[i] : handle_distance2(map, i, view);
#else
  real d2 = handle_distance2(map, i, view);
#endif
  real w = map->handles[(long)i * HANDLE_SIZE + 3] *
           power(pivot->e2 / most(d2, pivot->e2), map->alpha);
#if CUTS
  w = select(w, (real)(0), d2 >= UNREACHABLE);
#endif
  return w;
}

// d log(w_i)/dv.
inline vec weight_slope(const map_t *map, int i, const view_t *view) {
  __global const float *handle = map->handles + (long)i * HANDLE_SIZE;
  vec q = {handle[0], handle[1], handle[2]};
  real d2 = straight_distance2(handle, view->v);
  vec slope = vec_scale(2 * map->alpha / most(d2, 1e-30f), vec_sub(q, view->v));
#if CUTS
  slope = vec_add(slope, damping_slope(&map->cuts, view, i, q, d2));
#endif
  return slope;
}

// d log(w_k)/dv, to be taken from all slopes: a factor that all weights share changes nothing.
inline vec pivot_slope(const map_t *map, const pivot_t *pivot, const view_t *view) {
#if CUTS
  vec slope = {0, 0, 0};
  for (int i = 0; i < map->count; ++i)
    slope = vec_select(slope, weight_slope(map, i, view), pivot->k == i);
  return slope;
#else
  return vec_scale(-2 * map->alpha / most(pivot->d2, 1e-30f), pivot->x);
#endif
}
