// Surfaces of triangles, vtk_mls/model/cuts/surface.py. The detour bends on an edge of the boundary.
//
// A record: number of triangles, number of edges, corners of the triangles, ends of the edges.

#ifndef ASIDE
#error "ASIDE is missing: a direction that occurs in no designed surface"
#endif
#define TRIANGLE_SIZE 9
#define EDGE_SIZE 6

PLAIN_POINTS(surface)

inline __global const float *triangle_of(__global const float *cut, int i) {
  return cut + 2 + (long)i * TRIANGLE_SIZE;
}

inline __global const float *edge_of(__global const float *cut, int i) {
  return triangle_of(cut, as_int(cut[0])) + (long)i * EDGE_SIZE;
}

// Rounding of the side of an edge on which a segment passes, relative to the length of the segment.
#define BLUR 1e-6f

// On which side of the edge a - b the line along `segment` passes: the sign of `side`, or within
// rounding, that of the line shifted along ASIDE. So a line through a corner passes one of its triangles.
inline integer right_of(real side, vec segment, real blur, __global const float *a,
                        __global const float *b) {
  float3 moment = cross((float3)(b[0] - a[0], b[1] - a[1], b[2] - a[2]), ASIDE);
  real aside = fma(segment.x, moment.x, fma(segment.y, moment.y, segment.z * moment.z));
  return select(side, aside, fabs(side) <= blur) < 0;
}

// Whether the segment v - q passes the triangle; of two that share an edge just one.
inline integer crosses_triangle(__global const float *corners, vec v, vec q) {
  vec a = vec_sub(load3(corners), v), b = vec_sub(load3(corners + 3), v),
      c = vec_sub(load3(corners + 6), v), segment = vec_sub(q, v);
  vec ab = cross3(a, b), bc = cross3(b, c), ac = cross3(a, c);
  vec normal = {ab.x + bc.x - ac.x, ab.y + bc.y - ac.y, ab.z + bc.z - ac.z};
  real from = -dot3(a, normal), to = from + dot3(segment, normal);
  real blur = BLUR * (fabs(segment.x) + fabs(segment.y) + fabs(segment.z));
  integer right_ab = right_of(dot3(segment, ab), segment, blur, corners, corners + 3),
          right_bc = right_of(dot3(segment, bc), segment, blur, corners + 3, corners + 6),
          right_ac = right_of(dot3(segment, ac), segment, blur, corners, corners + 6);
  return ((from < 0) != (to < 0)) & (right_ab == right_bc) & (right_bc != right_ac);
}

inline integer surface_blocks(__global const float *cut, vec v, vec q) {
  integer odd = 0;
  const int triangles = as_int(cut[0]);
  for (int i = 0; i < triangles; ++i) odd ^= crosses_triangle(triangle_of(cut, i), v, q);
  return odd;
}

// Where the detour v - b - q over an edge bends.
inline vec bend_on_edge(__global const float *edge, vec v, vec q) {
  vec a = load3(edge), segment = vec_sub(load3(edge + 3), a);
  real length = sqrt(dot3(segment, segment));
  vec along = vec_scale(1 / length, segment);
  vec to_v = vec_sub(v, a), to_q = vec_sub(q, a);
  real l_v = dot3(to_v, along), l_q = dot3(to_q, along);
  vec off_v = vec_madd(-l_v, along, to_v), off_q = vec_madd(-l_q, along, to_q);
  real r_v = sqrt(dot3(off_v, off_v)), r_q = sqrt(dot3(off_q, off_q));
  real share = r_v / fast_max(r_v + r_q, 1e-30f);
  return vec_madd(fast_min(fast_max(fma(l_q - l_v, share, l_v), (real)(0)), length), along, a);
}

inline real surface_detour(__global const float *cut, vec v, vec q, vec *bend) {
  real shortest = FLT_MAX;
  vec nearest = v;  // not *bend: compilers keep that in memory
  const int edges = as_int(cut[1]);
  for (int i = 0; i < edges; ++i) {
    vec at = bend_on_edge(edge_of(cut, i), v, q);
    real length = distance3(v, at) + distance3(q, at);
    nearest = vec_select(nearest, at, length < shortest);
    shortest = fast_min(shortest, length);
  }
  *bend = nearest;
  real path = fast_min(shortest, (real)(1e8f));
  return select(path * path, (real)(NO_DETOUR), shortest >= UNREACHABLE);
}

inline real distance_to_segment(vec x, vec a, vec b) {
  vec segment = vec_sub(b, a), to = vec_sub(x, a);
  real share = clamp01(dot3(to, segment) / fast_max(dot3(segment, segment), (real)(1e-30f)));
  return distance3(to, vec_scale(share, segment));
}

inline real distance_to_triangle(__global const float *corners, vec x) {
  vec a = load3(corners), b = load3(corners + 3), c = load3(corners + 6);
  vec normal = unit3(cross3(vec_sub(b, a), vec_sub(c, a)));
  integer inside = (dot3(vec_sub(x, a), cross3(normal, vec_sub(b, a))) >= 0) &
                   (dot3(vec_sub(x, b), cross3(normal, vec_sub(c, b))) >= 0) &
                   (dot3(vec_sub(x, c), cross3(normal, vec_sub(a, c))) >= 0);
  real border = fast_min(distance_to_segment(x, a, b),
                     fast_min(distance_to_segment(x, b, c), distance_to_segment(x, c, a)));
  return select(border, fabs(dot3(vec_sub(x, a), normal)), inside);
}

// Between the segments v - g and an edge.
inline real distance_of_segments(vec v, vec g, __global const float *edge) {
  vec a = load3(edge), d1 = vec_sub(g, v), d2 = vec_sub(load3(edge + 3), a), r = vec_sub(v, a);
  real dd1 = dot3(d1, d1), dd2 = dot3(d2, d2), c = dot3(d1, r), f = dot3(r, d2), e = dot3(d1, d2);
  real det = dd1 * dd2 - e * e;
  integer is_parallel = det < 1e-12f * dd1 * dd2;
  real s = clamp01(select((e * f - c * dd2) / fast_max(det, 1e-30f), (real)(0), is_parallel));
  real t = clamp01(fma(e, s, f) / dd2);
  s = clamp01((e * t - c) / fast_max(dd1, 1e-30f));
  t = clamp01(fma(e, s, f) / dd2);
  return distance3(vec_madd(s, d1, r), vec_scale(t, d2));
}

inline real surface_void_distance(__global const float *cut, vec v, vec g) {
  real reach = FLT_MAX;
  const int triangles = as_int(cut[0]), edges = as_int(cut[1]);
  for (int i = 0; i < triangles; ++i)
    reach = fast_min(reach, distance_to_triangle(triangle_of(cut, i), g));
  for (int i = 0; i < edges; ++i)
    reach = fast_min(reach, distance_of_segments(v, g, edge_of(cut, i)));
  return select(reach, -reach, surface_blocks(cut, v, g));
}
