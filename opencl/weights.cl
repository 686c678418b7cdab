// The weights of Eq. 2: c_i / |q_i - v|^(2 alpha), for every power and distance in float32.
//
// k is the control point nearest to v, e the distance of the second nearest. All other control
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
  __global const float *handles;  // (count, HANDLE_SIZE)
  __global const float *values;   // (count, FUNCTIONS), basis functions at the control points
  __global const float *coefficients;  // (FUNCTIONS, MONOMIALS)
} map_t;

#define MAP_PARAMETERS                                                                       \
  const int handle_count, const float alpha, const int rotation_rank, const float4 flip_axis, \
      __global const float *restrict handles, __global const float *restrict values,         \
      __global const float *restrict coefficients
#define MAP \
  { handle_count, alpha, rotation_rank, flip_axis, handles, values, coefficients }

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

#if LANES > 1
// 2^x for x <= 0, relative error 1e-7. The built-in functions are exact to the last digit, and in
// vectors several times slower.
inline real fast_exp2(real x) {
  x = most(x, (real)(-126));
  real whole = rint(x), f = x - whole;
  real power = 0.00132764715f;
  power = fma(power, f, (real)(0.00967554133f));
  power = fma(power, f, (real)(0.0555071327f));
  power = fma(power, f, (real)(0.240221197f));
  power = fma(power, f, (real)(0.693146967f));
  power = fma(power, f, (real)(1.00000007f));
  return AS_REAL(AS_INTEGER(power) + (TO_INTEGER(whole) << 23));
}

// log2(x) for normal x > 0, absolute error 1e-7.
inline real fast_log2(real x) {
  // the exponent that leaves a mantissa in [sqrt(1/2), sqrt(2))
  integer exponent = (AS_INTEGER(x) - 0x3f3504f3) >> 23;
  real f = AS_REAL(AS_INTEGER(x) - (exponent << 23)) - 1;
  real series = -0.14575751f;
  series = fma(series, f, (real)(0.236882485f));
  series = fma(series, f, (real)(-0.250061196f));
  series = fma(series, f, (real)(0.28670854f));
  series = fma(series, f, (real)(-0.360088119f));
  series = fma(series, f, (real)(0.480939392f));
  series = fma(series, f, (real)(-0.721357121f));
  series = fma(series, f, (real)(1.44269477f));
  return fma(series, f, TO_REAL(exponent));
}
#else
#define fast_exp2 exp2
#define fast_log2 log2
#endif

// x^alpha for 0 <= x <= 1; the common powers without logarithms.
inline real power(real x, float alpha) {
#if TWICE_ALPHA == 1
  return sqrt(x);
#elif TWICE_ALPHA == 2
  return x;
#elif TWICE_ALPHA == 3
  return x * sqrt(x);
#elif TWICE_ALPHA == 4
  return x * x;
#elif TWICE_ALPHA == 6
  return x * x * x;
#else
  real result = fast_exp2(alpha * fast_log2(x));
  return select(result, (real)(0), x < FLT_MIN);
#endif
}

inline real handle_distance2(__global const float *handle, vec v) {
  real dx = handle[0] - v.x, dy = handle[1] - v.y, dz = handle[2] - v.z;
  return fma(dx, dx, fma(dy, dy, dz * dz));
}

inline pivot_t find_pivot(const map_t *map, vec v) {
  real first = FLT_MAX, second = FLT_MAX;
  integer k = 0;
  __global const float *handle = map->handles;
  for (int i = 0; i < map->count; ++i, handle += HANDLE_SIZE) {
    real d2 = handle_distance2(handle, v);
    integer nearer = d2 < first;
    real beaten = select(d2, first, nearer); second = select(second, beaten, beaten < second);
    first = select(first, d2, nearer);
    k = select(k, (integer)(i), nearer);
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
  pivot.x = vec_sub(v, pivot.q);
  pivot.d2 = first;
  pivot.e2 = most(second, 1e-30f);
  pivot.r = power(first / pivot.e2, map->alpha);
  return pivot;
}

// Weight of a control point next to the others but k.
inline real handle_weight(const map_t *map, __global const float *handle, const pivot_t *pivot,
                          vec v) {
  real d2 = handle_distance2(handle, v);
  return handle[3] * power(pivot->e2 / most(d2, pivot->e2), map->alpha);
}

// d log(w_i)/dv - d log(w_k)/dv: what changes of a weight when the common factor is left out.
inline vec weight_slope(const map_t *map, __global const float *handle, const pivot_t *pivot,
                        vec v) {
  real near = 2 * map->alpha / most(pivot->d2, 1e-30f);
  real far = 2 * map->alpha / most(handle_distance2(handle, v), 1e-30f);
  return (vec){fma(near, pivot->x.x, far * (handle[0] - v.x)),
               fma(near, pivot->x.y, far * (handle[1] - v.y)),
               fma(near, pivot->x.z, far * (handle[2] - v.z))};
}
