// Half-planes, vtk_mls/model/cuts/half_plane.py. The detour bends on the edge line.
//
// A record: point of the edge, normal, inward, along, then the frame of each control point.

// A constant, so that the cache is in registers: 2 % of a displacement field.
#ifndef HALF_PLANES
#error "HALF_PLANES is missing: number of half-planes"
#endif
#define HALF_PLANE_SIZE 12
#define FRAME_SIZE 4

// A point in the frame of a half-plane: height, depth, position along the edge, distance to it.
typedef struct { real s, h, l, r; } frame_t;
typedef frame_t half_plane_point_t;
typedef struct { frame_t frame[HALF_PLANES]; } half_plane_cache_t;

inline int half_plane_count(__global const float *table) { return HALF_PLANES; }

inline frame_t half_plane_point(__global const float *cut, vec x) {
  vec offset = vec_sub(x, load3(cut));
  real s = dot3(offset, load3(cut + 3)), h = dot3(offset, load3(cut + 6));
  return (frame_t){s, h, dot3(offset, load3(cut + 9)), sqrt(fma(s, s, h * h))};
}

inline half_plane_cache_t half_plane_cache(__global const float *table, vec v) {
  half_plane_cache_t cache;
  for (int i = 0; i < HALF_PLANES; ++i) cache.frame[i] = half_plane_point(record_of(table, i), v);
  return cache;
}

inline frame_t half_plane_cached(const half_plane_cache_t *cache, int i) { return cache->frame[i]; }

inline frame_t half_plane_control_point(__global const float *cut, int k, vec q) {
  __global const float *frame = cut + HALF_PLANE_SIZE + (long)k * FRAME_SIZE;
  return (frame_t){frame[0], frame[1], frame[2], frame[3]};
}

inline real half_plane_distance2(frame_t a, frame_t b) {
  real s = a.s - b.s, h = a.h - b.h, l = a.l - b.l;
  return fma(s, s, fma(h, h, l * l));
}

inline integer half_plane_blocks(__global const float *cut, frame_t a, frame_t b) {
  return ((a.s < 0) != (b.s < 0)) & (fma(a.h, fabs(b.s), b.h * fabs(a.s)) > 0);
}

inline real half_plane_detour(__global const float *cut, frame_t a, frame_t b, vec *bend) {
  real radius = a.r + b.r, along = a.l - b.l;
  real l = fma(b.l - a.l, a.r / fast_max(radius, 1e-30f), a.l);
  *bend = vec_madd(l, load3(cut + 9), load3(cut));
  return fma(radius, radius, along * along);
}

inline real half_plane_void_distance(__global const float *cut, frame_t a, frame_t b) {
  real to_cut = select(b.r, fabs(b.s), b.h > 0);
  real ds = b.s - a.s, dh = b.h - a.h;
  real share = clamp01(-fma(a.s, ds, a.h * dh) / fast_max(fma(ds, ds, dh * dh), 1e-30f));
  real s = fma(ds, share, a.s), h = fma(dh, share, a.h);
  real reach = fast_min(to_cut, sqrt(fma(s, s, h * h)));
  return select(reach, -reach, half_plane_blocks(cut, a, b));
}
