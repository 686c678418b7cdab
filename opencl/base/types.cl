// Scalars and vectors of points. A work item computes LANES points at once: explicit vectors on CPUs,
// as no compiler vectorizes the loop over control points, and one point on GPUs. Branches that depend
// on the point are written as select(). The macros of all files are listed in README.md.

#ifndef LANES
#error "LANES is missing: points per work item, 1, 2, 4, 8 or 16"
#endif

// Intel's compiler and PoCL also build functions that the kernel does not call, unless they are static.
#define inline static inline

#include "structs.h"

#define GLUE_(a, b) a##b
#define GLUE(a, b) GLUE_(a, b)

// OF_LANES(type) is the type of a value for each point.
#if LANES == 1
#define OF_LANES(type) type
#define ANY(condition) (condition)
#define ALL(condition) (condition)
#define TO_INTEGER(x) ((int)(x))
#define TO_REAL(i) ((float)(i))
#define LOAD(from) (*(from))
#define STORE(value, to) (*(to) = (value))
#define STORE_FLAGS(flags, to) (*(to) = (uchar)((flags) & 1))
#define LANES_AFTER(a, last) (last)
#define FETCH(from)
#else
#define OF_LANES(type) GLUE(type, LANES)
#define ANY(condition) (GLUE(union, LANES)(condition) != 0)
#define ALL(condition) (!ANY(!(condition)))
#define TO_INTEGER(x) GLUE(convert_int, LANES)(x)
#define TO_REAL(i) GLUE(convert_float, LANES)(i)
#define AS_INTEGER(x) GLUE(as_int, LANES)(x)
#define AS_REAL(i) GLUE(as_float, LANES)(i)
#define LOAD(from) GLUE(vload, LANES)(0, from)
#define STORE(value, to) GLUE(vstore, LANES)(value, 0, to)
#define STORE_FLAGS(flags, to) GLUE(vstore, LANES)(GLUE(convert_uchar, LANES)((flags) & 1), 0, to)
// The lanes after the first, and `last`.
#define AFTER(n) ((n) + 1)
#define LANES_AFTER(a, last) __builtin_shufflevector(a, (real)(last), EACH_LANE(AFTER, 0))
#define FETCH(from) __builtin_prefetch((const void *)(size_t)(from))
#endif
typedef OF_LANES(float) real;
typedef OF_LANES(int) integer;

// A store past the caches, for results larger than these; `to` must be aligned as a vector.
#ifdef __has_builtin
#if LANES > 1 && __has_builtin(__builtin_nontemporal_store)
#define STREAM(value, to) __builtin_nontemporal_store(value, (__global real *)(to))
#define IS_ALIGNED(to) ((size_t)(to) % sizeof(real) == 0)
#endif
#endif
#ifndef STREAM
#define STREAM(value, to) STORE(value, to)
#define IS_ALIGNED(to) 0
#endif

#if LANES > 1
// The bitwise or of all lanes. PoCL compiles the built-in any() to a branch per two lanes, which
// processors predict badly.
inline int union2(int2 lanes) { return lanes.x | lanes.y; }
inline int union4(int4 lanes) { return union2(lanes.lo | lanes.hi); }
inline int union8(int8 lanes) { return union4(lanes.lo | lanes.hi); }
inline int union16(int16 lanes) { return union8(lanes.lo | lanes.hi); }
#endif

// Attribute of all kernels: the compiler must not auto-vectorize. Intel's would split our vectors, or
// combine work items, and results would depend in the last bit on neighboring work items.
#define EXPLICIT_VECTORS __attribute__((vec_type_hint(float16)))

// A function of the innermost loops: a call would pass vectors through memory.
#define HOT inline __attribute__((always_inline))

// Before a short loop over an array of vectors: else PoCL keeps the array in memory.
#define UNROLL_ALL _Pragma("unroll")

// Lane l of a vector, to read or to write.
#define LANE(vector, l) (((float *)&(vector))[l])
#define LANE_INT(vector, l) (((int *)&(vector))[l])

inline integer lane_indices() {
  integer indices;
  for (int l = 0; l < LANES; ++l) LANE_INT(indices, l) = l;
  return indices;
}

typedef struct { real x, y, z; } vec;
typedef struct { real a[9]; } mat;  // row by row

// One instruction each, unlike fmin() and fmax() with their rules for NaN.
inline real fast_min(real a, real b) { return a < b ? a : b; }
inline real fast_max(real a, real b) { return a > b ? a : b; }

inline vec vec_add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
inline vec vec_sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
inline vec vec_scale(real s, vec a) { return (vec){s * a.x, s * a.y, s * a.z}; }
inline vec vec_madd(real s, vec a, vec b) {
  return (vec){fma(s, a.x, b.x), fma(s, a.y, b.y), fma(s, a.z, b.z)};
}
inline real dot3(vec a, vec b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
inline vec cross3(vec a, vec b) {
  return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline vec vec_select(vec a, vec b, integer c) {
  return (vec){select(a.x, b.x, c), select(a.y, b.y, c), select(a.z, b.z, c)};
}
inline real clamp01(real x) { return fast_min(fast_max(x, (real)(0)), (real)(1)); }

// The same point in all lanes.
inline vec load3(__global const float *from) { return (vec){from[0], from[1], from[2]}; }

HOT void set_lane(vec *points, int l, float3 point) {
  LANE(points->x, l) = point.x, LANE(points->y, l) = point.y, LANE(points->z, l) = point.z;
}

// Planes: the x coordinates of `count` points, then y, then z, and so on.

// LANES values of a plane from `first` on; past the end the last value is repeated.
inline real load_plane(__global const float *plane, long count, long first) {
  if (first + LANES <= count) return LOAD(plane + first);
  real value;
  for (int l = 0; l < LANES; ++l) LANE(value, l) = plane[min(first + l, count - 1)];
  return value;
}

inline void store_plane(__global float *plane, real value, long count, long first) {
  if (first + LANES <= count) {
    STORE(value, plane + first);
    return;
  }
  for (int l = 0; l < (int)(count - first); ++l) plane[first + l] = LANE(value, l);
}

inline vec load_points(__global const float *planes, long count, long first) {
  return (vec){load_plane(planes, count, first), load_plane(planes + count, count, first),
               load_plane(planes + 2 * count, count, first)};
}

inline void store_points(__global float *planes, vec value, long count, long first) {
  store_plane(planes, value.x, count, first);
  store_plane(planes + count, value.y, count, first);
  store_plane(planes + 2 * count, value.z, count, first);
}

// Interleaved points: x, y, z of a point, then of the next. The n-th float of LANES points is
// coordinate n % 3 of lane n / 3. Without explicit shuffles compilers store the floats one by one.
#if LANES > 1
#define EACH2(of, n) of(n), of((n) + 1)
#define EACH4(of, n) EACH2(of, n), EACH2(of, (n) + 2)
#define EACH8(of, n) EACH4(of, n), EACH4(of, (n) + 4)
#define EACH16(of, n) EACH8(of, n), EACH8(of, (n) + 8)
#define EACH_LANE(of, n) GLUE(EACH, LANES)(of, n)
#define X_OR_Y(n) ((n) % 3 == 2 ? -1 : (n) % 3 * LANES + (n) / 3)
#define OR_Z(n) ((n) % 3 == 2 ? LANES + (n) / 3 : (n) % LANES)
#define INTERLEAVED(a, n)                                                                  \
  __builtin_shufflevector(__builtin_shufflevector(a.x, a.y, EACH_LANE(X_OR_Y, n)), a.z,    \
                          EACH_LANE(OR_Z, n))
#else
#define INTERLEAVED(a, n) ((n) == 0 ? a.x : (n) == 1 ? a.y : a.z)
#endif
inline void store_point(__global float *to, vec a, int l) {
  to[0] = LANE(a.x, l);
  to[1] = LANE(a.y, l);
  to[2] = LANE(a.z, l);
}

HOT void store_interleaved(__global float *to, vec a, int lanes) {
  if (lanes == LANES) {
    STORE(INTERLEAVED(a, 0), to);
    STORE(INTERLEAVED(a, LANES), to + LANES);
    STORE(INTERLEAVED(a, 2 * LANES), to + 2 * LANES);
    return;
  }
  for (int l = 0; l < lanes; ++l) store_point(to + 3 * l, a, l);
}

// `to` has three vectors: a pointer, as the caller may have it from a struct (digit_loss.cl).
HOT void set_interleaved(real *to, vec a) {
  to[0] = INTERLEAVED(a, 0);
  to[1] = INTERLEAVED(a, LANES);
  to[2] = INTERLEAVED(a, 2 * LANES);
}

// 1 / sqrt(x) for normal x > 0, relative error 2e-7. Of Intel's runtime rsqrt() is a call, and
// native_rsqrt() has half of the digits.
inline real fast_rsqrt(real x) {
  real y = native_rsqrt(x);
  return y * fma(-0.5f * x * y, y, (real)(1.5f));
}

// a / |a|, and 0 for a = 0.
inline vec unit3(vec a) {
  real square = dot3(a, a);
  integer vanishes = square < 1e-30f;
  return vec_scale(select(fast_rsqrt(square), (real)(0), vanishes), a);
}

HOT vec mat_row(const mat *m, int i) {
  return (vec){m->a[3 * i], m->a[3 * i + 1], m->a[3 * i + 2]};
}
HOT void set_mat_row(mat *m, int i, vec row) {
  m->a[3 * i] = row.x, m->a[3 * i + 1] = row.y, m->a[3 * i + 2] = row.z;
}
HOT vec mat_column(const mat *m, int j) { return (vec){m->a[j], m->a[3 + j], m->a[6 + j]}; }
HOT void set_mat_column(mat *m, int j, vec column) {
  m->a[j] = column.x, m->a[3 + j] = column.y, m->a[6 + j] = column.z;
}

inline vec mat_vec(const mat *m, vec v) {
  return (vec){dot3(mat_row(m, 0), v), dot3(mat_row(m, 1), v), dot3(mat_row(m, 2), v)};
}
inline vec transposed_mat_vec(const mat *m, vec v) {
  return (vec){dot3(mat_column(m, 0), v), dot3(mat_column(m, 1), v), dot3(mat_column(m, 2), v)};
}

// m += a b^T
inline void add_outer(mat *m, vec a, vec b) {
  set_mat_row(m, 0, vec_madd(a.x, b, mat_row(m, 0)));
  set_mat_row(m, 1, vec_madd(a.y, b, mat_row(m, 1)));
  set_mat_row(m, 2, vec_madd(a.z, b, mat_row(m, 2)));
}

// The size that rounding of a local x is relative to.
inline real size_of(vec x) {
  return fast_max(fast_max(fast_max(fabs(x.x), fabs(x.y)), fabs(x.z)), (real)(1));
}

// d with (I + J) d = r for a matrix J; r itself where I + J is singular.
inline vec identity_solve(const mat *j, vec r) {
  vec a = {1 + j->a[0], j->a[1], j->a[2]};
  vec b = {j->a[3], 1 + j->a[4], j->a[5]};
  vec c = {j->a[6], j->a[7], 1 + j->a[8]};
  vec bc = cross3(b, c), ca = cross3(c, a), ab = cross3(a, b);
  real det = dot3(a, bc);
  vec d = vec_madd(r.x, bc, vec_madd(r.y, ca, vec_scale(r.z, ab)));
  integer singular = fabs(det) < 1e-6f;
  return vec_select(vec_scale(1 / select(det, (real)(1), singular), d), r, singular);
}

// Four numbers in a cell by trilinear interpolation, and their changes along x, y and z.
typedef struct { float4 value, by_x, by_y, by_z; } trilinear_t;

// At the share (a, b, c) of a cell with the first corner at `low`; so far apart are rows and layers.
inline trilinear_t trilinear(__global const float *low, int row, int layer, float a, float b,
                             float c) {
  __global const float *high = low + 4 * layer;
  const float4 c00 = vload4(0, low), c10 = vload4(row, low), c01 = vload4(0, high),
               c11 = vload4(row, high);
  const float4 x00 = vload4(1, low) - c00, x10 = vload4(row + 1, low) - c10,
               x01 = vload4(1, high) - c01, x11 = vload4(row + 1, high) - c11;
  const float4 v00 = c00 + a * x00, v10 = c10 + a * x10, v01 = c01 + a * x01, v11 = c11 + a * x11;
  const float4 y0 = v10 - v00, y1 = v11 - v01, w0 = v00 + b * y0, w1 = v01 + b * y1;
  const float4 x0 = x00 + b * (x10 - x00), x1 = x01 + b * (x11 - x01);
  return (trilinear_t){w0 + c * (w1 - w0), x0 + c * (x1 - x0), y0 + c * (y1 - y0), w1 - w0};
}

// Sets the columns of a matrix in a lane.
inline void set_mat_lane(mat *m, int l, float3 x, float3 y, float3 z) {
  LANE(m->a[0], l) = x.x, LANE(m->a[1], l) = y.x, LANE(m->a[2], l) = z.x;
  LANE(m->a[3], l) = x.y, LANE(m->a[4], l) = y.y, LANE(m->a[5], l) = z.y;
  LANE(m->a[6], l) = x.z, LANE(m->a[7], l) = y.z, LANE(m->a[8], l) = z.z;
}

// An affine transform t of x: columns for x, y, z, then the offset, three floats each.
inline vec transformed(const float *t, vec x) {
  return (vec){
      fma((real)(t[0]), x.x, fma((real)(t[3]), x.y, fma((real)(t[6]), x.z, (real)(t[9])))),
      fma((real)(t[1]), x.x, fma((real)(t[4]), x.y, fma((real)(t[7]), x.z, (real)(t[10])))),
      fma((real)(t[2]), x.x, fma((real)(t[5]), x.y, fma((real)(t[8]), x.z, (real)(t[11]))))};
}
