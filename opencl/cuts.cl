// Cuts (section 4): the damping of Eq. 28, and the void. Shapes and rules: vtk_mls/cuts.py.
//
// Full planes do not appear here as obstacles: the host gives each of their sides its own control
// points, and a launch computes the places of one side (`in_region`).

// Numbers per shape in memory.
#define PLANE_SIZE 4       // normal (3), height of the origin
#define HALF_PLANE_SIZE 12 // point of the edge, normal, inward, along
#define FRAME_SIZE 4       // of a control point: height, depth, place along the edge, radius
#define TRIANGLE_SIZE 9
#define EDGE_SIZE 6

typedef struct {
  float damping;                           // nu / (2 alpha)
  float nu;
  float4 drift;                            // local units
  int plane_count;
  __global const float *planes;            // (plane_count, PLANE_SIZE)
  __global const float *index_planes;      // the same for indices of the launch's grid
  __global const float *sides;             // (plane_count), of this region: 1 or -1
  __global const float *half_planes;       // (HALF_PLANES, HALF_PLANE_SIZE)
  __global const float *frames;            // (control points, HALF_PLANES, FRAME_SIZE)
  int surface_count;
  __global const int *surfaces;            // (surface_count, 4): triangles from, to, edges from, to
  __global const float *triangles;         // (triangles, TRIANGLE_SIZE), corners sorted
  __global const float *edges;             // (edges, EDGE_SIZE), of the boundary
} cuts_t;

#define CUT_PARAMETERS                                                                         \
  , const float damping, const float nu, const float4 drift_local, const int plane_count,      \
      __global const float *restrict planes, __global const float *restrict index_planes,      \
      __global const float *restrict sides, __global const float *restrict half_planes,        \
      __global const float *restrict frames,                                                   \
      const int surface_count, __global const int *restrict surfaces,                          \
      __global const float *restrict triangles, __global const float *restrict edges
#define CUTS_OF_LAUNCH                                                                         \
  , { damping, nu, drift_local, plane_count, planes, index_planes, sides, half_planes, frames,  \
      surface_count, surfaces, triangles, edges }

// A place in the frame of a half-plane: height, depth, place along the edge, distance to it.
typedef struct { real s, h, l, r; } frame_t;

inline vec load3(__global const float *from) { return (vec){from[0], from[1], from[2]}; }

inline real plane_height(__global const float *plane, vec x) {
  return fma(plane[0], x.x, fma(plane[1], x.y, fma(plane[2], x.z, (real)(plane[3]))));
}

// Whether the point of a grid with this index is on this launch's side of all planes. Indices are the
// same numbers in every launch, so each point belongs to just one.
inline integer in_region(const cuts_t *cuts, vec index) {
  integer inside = (real)(0) == 0;
  for (int i = 0; i < cuts->plane_count; ++i) {
    integer below = plane_height(cuts->index_planes + i * PLANE_SIZE, index) < 0;
    inside &= cuts->sides[i] < 0 ? below : !below;
  }
  return inside;
}

// Local place where the material at v came from, for its displacement less drift.
inline vec origin_of(const cuts_t *cuts, vec v, vec d) {
  float4 drift = cuts->drift;
  return vec_add(vec_add(v, d), (vec){drift.x, drift.y, drift.z});
}

inline frame_t frame_of(__global const float *half_plane, vec x) {
  vec offset = vec_sub(x, load3(half_plane));
  real s = dot3(offset, load3(half_plane + 3)), h = dot3(offset, load3(half_plane + 6));
  return (frame_t){s, h, dot3(offset, load3(half_plane + 9)), sqrt(fma(s, s, h * h))};
}

inline integer half_plane_blocks(frame_t a, frame_t b) {
  return ((a.s < 0) != (b.s < 0)) & (fma(a.h, fabs(b.s), b.h * fabs(a.s)) > 0);
}

#define ASIDE (float3)(0.5377f, 0.2863f, 0.7930f)  // no direction that surfaces have by design
#define BLUR 1e-6f  // times a way: below it float32 does not tell on which side of an edge it passes

// On which side of the edge a - b the line along `way` passes: the sign of `side`, or where that is
// in the blur, of the line moved aside, so that one through a corner passes one of its triangles.
inline integer right_of(real side, vec way, real blur, __global const float *a,
                        __global const float *b) {
  float3 turn = cross((float3)(b[0] - a[0], b[1] - a[1], b[2] - a[2]), ASIDE);
  real aside = fma(way.x, turn.x, fma(way.y, turn.y, way.z * turn.z));
  return select(side, aside, fabs(side) <= blur) < 0;
}

// Whether the segment v - q passes the triangle; of two that share an edge just one.
inline integer crosses_triangle(__global const float *corners, vec v, vec q) {
  vec a = vec_sub(load3(corners), v), b = vec_sub(load3(corners + 3), v),
      c = vec_sub(load3(corners + 6), v), way = vec_sub(q, v);
  vec ab = cross3(a, b), bc = cross3(b, c), ac = cross3(a, c);
  vec normal = {ab.x + bc.x - ac.x, ab.y + bc.y - ac.y, ab.z + bc.z - ac.z};
  real from = -dot3(a, normal), to = from + dot3(way, normal);
  real blur = BLUR * (fabs(way.x) + fabs(way.y) + fabs(way.z));
  integer right_ab = right_of(dot3(way, ab), way, blur, corners, corners + 3),
          right_bc = right_of(dot3(way, bc), way, blur, corners + 3, corners + 6),
          right_ac = right_of(dot3(way, ac), way, blur, corners, corners + 6);
  return ((from < 0) != (to < 0)) & (right_ab == right_bc) & (right_bc != right_ac);
}

inline integer surface_blocks(const cuts_t *cuts, int surface, vec v, vec q) {
  __global const int *range = cuts->surfaces + 4 * surface;
  integer odd = 0;
  for (int i = range[0]; i < range[1]; ++i)
    odd ^= crosses_triangle(cuts->triangles + (long)i * TRIANGLE_SIZE, v, q);
  return odd;
}

// Whether a cut that one can go round is between v and g.
inline integer blocked(const cuts_t *cuts, vec v, vec g) {
  integer anything = 0;
#if HALF_PLANES
  for (int i = 0; i < HALF_PLANES; ++i) {
    __global const float *half_plane = cuts->half_planes + i * HALF_PLANE_SIZE;
    anything |= half_plane_blocks(frame_of(half_plane, v), frame_of(half_plane, g));
  }
#endif
#if SURFACES
  for (int i = 0; i < cuts->surface_count; ++i) anything |= surface_blocks(cuts, i, v, g);
#endif
  return anything;
}

// What comes to lie on a plane is on both sides, to rounding.
#define ON_PLANE 1e-6f

// Whether x, local, is on this launch's side of all planes, for what rounding is relative to.
inline integer on_side(const cuts_t *cuts, vec x, real size) {
  integer inside = (real)(0) == 0;
  for (int i = 0; i < cuts->plane_count; ++i)
    inside &= cuts->sides[i] * plane_height(cuts->planes + i * PLANE_SIZE, x) >= -ON_PLANE * size;
  return inside;
}

// Where the detour v - b - q over an edge bends.
inline vec bend_on_edge(__global const float *edge, vec v, vec q) {
  vec a = load3(edge), way = vec_sub(load3(edge + 3), a);
  real length = sqrt(dot3(way, way));
  vec along = vec_scale(1 / length, way);
  vec to_v = vec_sub(v, a), to_q = vec_sub(q, a);
  real l_v = dot3(to_v, along), l_q = dot3(to_q, along);
  vec off_v = vec_madd(-l_v, along, to_v), off_q = vec_madd(-l_q, along, to_q);
  real r_v = sqrt(dot3(off_v, off_v)), r_q = sqrt(dot3(off_q, off_q));
  real share = r_v / most(r_v + r_q, 1e-30f);
  return vec_madd(least(most(fma(l_q - l_v, share, l_v), (real)(0)), length), along, a);
}

inline real distance3(vec a, vec b) {
  vec d = vec_sub(a, b);
  return sqrt(dot3(d, d));
}

// Length of the detour round a surface, and where it bends; FLT_MAX for a closed one.
inline real surface_detour(const cuts_t *cuts, int surface, vec v, vec q, vec *bend) {
  __global const int *range = cuts->surfaces + 4 * surface;
  real shortest = FLT_MAX;
  *bend = v;
  for (int i = range[2]; i < range[3]; ++i) {
    vec at = bend_on_edge(cuts->edges + (long)i * EDGE_SIZE, v, q);
    real length = distance3(v, at) + distance3(q, at);
    *bend = vec_select(*bend, at, length < shortest);
    shortest = least(shortest, length);
  }
  return shortest;
}

// Where the detour round a half-plane bends.
inline vec half_plane_bend(__global const float *half_plane, frame_t a, frame_t b) {
  real l = fma(b.l - a.l, a.r / most(a.r + b.r, 1e-30f), a.l);
  return vec_madd(l, (vec){half_plane[9], half_plane[10], half_plane[11]}, load3(half_plane));
}

inline real half_plane_path2(frame_t a, frame_t b) {
  real radius = a.r + b.r, along = a.l - b.l;
  return fma(radius, radius, along * along);
}

inline frame_t load_frame(const cuts_t *cuts, int handle, int cut) {
  __global const float *frame = cuts->frames + ((long)handle * HALF_PLANES + cut) * FRAME_SIZE;
  return (frame_t){frame[0], frame[1], frame[2], frame[3]};
}

// Squared distance of what a closed surface keeps apart, at least.
#define UNREACHABLE 1e29f

// Distances that are kept between the two passes over the control points; registers of a GPU are few.
#if LANES > 1
#define KNOWN 64
#else
#define KNOWN 0
#endif

// A place with what the cuts need to know of it.
typedef struct {
  vec v;
#if KNOWN
  real known[KNOWN];  // damped squared distances of the first control points
#endif
#if HALF_PLANES
  frame_t frame[HALF_PLANES];
#endif
} view_t;

inline view_t view_of(const cuts_t *cuts, vec v) {
  view_t view;
  view.v = v;
#if HALF_PLANES
  for (int i = 0; i < HALF_PLANES; ++i)
    view.frame[i] = frame_of(cuts->half_planes + i * HALF_PLANE_SIZE, v);
#endif
  return view;
}

// ratio^damping; the common powers, nu / alpha = 2, 3 and 4, without logarithms.
inline real to_damping(real ratio, float damping) {
  if (damping == 1) return ratio;
  if (damping == 1.5f) return ratio * sqrt(ratio);
  if (damping == 2) return ratio * ratio;
  return fast_exp2(damping * fast_log2(ratio));
}

// Squared distance that gives a control point the weight of Eq. 27 without damping: d2 times the
// product of (detour / way)^(nu / alpha) over the cuts in the way.
inline real damped_distance2(const cuts_t *cuts, const view_t *view, int handle, vec q, real d2) {
  real ratio = 1;
  integer anything = 0, unreachable = 0;
#if HALF_PLANES
  for (int i = 0; i < HALF_PLANES; ++i) {
    frame_t frame = load_frame(cuts, handle, i);
    if (!ANY((view->frame[i].s < 0) != (frame.s < 0))) continue;
    integer blocked = half_plane_blocks(view->frame[i], frame);
    if (ANY(blocked)) {
      real longer = half_plane_path2(view->frame[i], frame) / most(d2, 1e-30f);
      ratio = select(ratio, ratio * most(longer, (real)(1)), blocked);
      anything |= blocked;
    }
  }
#endif
#if SURFACES
  for (int i = 0; i < cuts->surface_count; ++i) {
    integer blocked = surface_blocks(cuts, i, view->v, q);
    if (ANY(blocked)) {
      vec bend;
      real path = surface_detour(cuts, i, view->v, q, &bend);
      unreachable |= blocked & (path >= UNREACHABLE);
      path = least(path, (real)(1e8f));
      ratio = select(ratio, ratio * most(path * path / most(d2, 1e-30f), (real)(1)), blocked);
      anything |= blocked;
    }
  }
#endif
  if (!ANY(anything)) return d2;
  d2 = select(d2, d2 * to_damping(ratio, cuts->damping), anything);
  return select(d2, (real)(2 * UNREACHABLE), unreachable);
}

// d log(d)/dv for the damping d of Eq. 28.
inline vec damping_slope(const cuts_t *cuts, const view_t *view, int handle, vec q, real d2) {
  vec away = vec_scale(1 / most(d2, 1e-30f), vec_sub(view->v, q)), slope = {0, 0, 0};
#if HALF_PLANES
  for (int i = 0; i < HALF_PLANES; ++i) {
    frame_t frame = load_frame(cuts, handle, i);
    integer blocked = half_plane_blocks(view->frame[i], frame);
    if (ANY(blocked)) {
      vec bend = half_plane_bend(cuts->half_planes + i * HALF_PLANE_SIZE, view->frame[i], frame);
      vec leg = vec_sub(view->v, bend);
      real path = sqrt(half_plane_path2(view->frame[i], frame));
      real scale = 1 / most(sqrt(dot3(leg, leg)) * path, 1e-30f);
      slope = vec_select(slope, vec_add(slope, vec_sub(away, vec_scale(scale, leg))), blocked);
    }
  }
#endif
#if SURFACES
  for (int i = 0; i < cuts->surface_count; ++i) {
    integer blocked = surface_blocks(cuts, i, view->v, q);
    if (ANY(blocked)) {
      vec bend;
      real path = least(surface_detour(cuts, i, view->v, q, &bend), (real)(1e8f));
      vec leg = vec_sub(view->v, bend);
      real scale = 1 / most(sqrt(dot3(leg, leg)) * path, 1e-30f);
      slope = vec_select(slope, vec_add(slope, vec_sub(away, vec_scale(scale, leg))), blocked);
    }
  }
#endif
  return vec_scale((real)(cuts->nu), slope);
}

inline real distance_to_segment(vec x, vec a, vec b) {
  vec way = vec_sub(b, a), to = vec_sub(x, a);
  real share = dot3(to, way) / most(dot3(way, way), (real)(1e-30f));
  share = least(most(share, (real)(0)), (real)(1));
  return distance3(to, vec_scale(share, way));
}

inline real distance_to_triangle(__global const float *corners, vec x) {
  vec a = load3(corners), b = load3(corners + 3), c = load3(corners + 6);
  vec normal = unit3(cross3(vec_sub(b, a), vec_sub(c, a)));
  integer inside = (dot3(vec_sub(x, a), cross3(normal, vec_sub(b, a))) >= 0) &
                   (dot3(vec_sub(x, b), cross3(normal, vec_sub(c, b))) >= 0) &
                   (dot3(vec_sub(x, c), cross3(normal, vec_sub(a, c))) >= 0);
  real border = least(distance_to_segment(x, a, b),
                     least(distance_to_segment(x, b, c), distance_to_segment(x, c, a)));
  return select(border, fabs(dot3(vec_sub(x, a), normal)), inside);
}

inline real clamp01(real x) { return least(most(x, (real)(0)), (real)(1)); }

// Between the segments v - g and an edge.
inline real distance_of_segments(vec v, vec g, __global const float *edge) {
  vec a = load3(edge), d1 = vec_sub(g, v), d2 = vec_sub(load3(edge + 3), a), r = vec_sub(v, a);
  real dd1 = dot3(d1, d1), dd2 = dot3(d2, d2), c = dot3(d1, r), f = dot3(r, d2), e = dot3(d1, d2);
  real det = dd1 * dd2 - e * e;
  real s = clamp01(select((e * f - c * dd2) / most(det, 1e-30f), (real)(0), det < 1e-12f * dd1 * dd2));
  real t = clamp01(fma(e, s, f) / dd2);
  s = clamp01((e * t - c) / most(dd1, 1e-30f));
  t = clamp01(fma(e, s, f) / dd2);
  return distance3(vec_madd(s, d1, r), vec_scale(t, d2));
}

// The opening: below 0 where the way from v to its origin g crosses a cut, so that there is nothing
// at v; continuous on each side of the cuts. Local units.
inline real opening_of(const cuts_t *cuts, vec v, vec g) {
  real opening = FLT_MAX;
  for (int i = 0; i < cuts->plane_count; ++i) {
    opening = least(opening, cuts->sides[i] * plane_height(cuts->planes + i * PLANE_SIZE, g));
  }
#if HALF_PLANES
  for (int i = 0; i < HALF_PLANES; ++i) {
    frame_t a = frame_of(cuts->half_planes + i * HALF_PLANE_SIZE, v);
    frame_t b = frame_of(cuts->half_planes + i * HALF_PLANE_SIZE, g);
    real to_cut = select(b.r, fabs(b.s), b.h > 0);
    real ds = b.s - a.s, dh = b.h - a.h;
    real share = clamp01(-fma(a.s, ds, a.h * dh) / most(fma(ds, ds, dh * dh), 1e-30f));
    real s = fma(ds, share, a.s), h = fma(dh, share, a.h);
    real reach = least(to_cut, sqrt(fma(s, s, h * h)));
    opening = least(opening, select(reach, -reach, half_plane_blocks(a, b)));
  }
#endif
#if SURFACES
  for (int i = 0; i < cuts->surface_count; ++i) {
    __global const int *range = cuts->surfaces + 4 * i;
    real reach = FLT_MAX;
    for (int t = range[0]; t < range[1]; ++t)
      reach = least(reach, distance_to_triangle(cuts->triangles + (long)t * TRIANGLE_SIZE, g));
    for (int e = range[2]; e < range[3]; ++e)
      reach = least(reach, distance_of_segments(v, g, cuts->edges + (long)e * EDGE_SIZE));
    opening = least(opening, select(reach, -reach, surface_blocks(cuts, i, v, g)));
  }
#endif
  return opening;
}
