// The rotation R (p = R q, columns) that maximizes tr(R^T C), Eq. 9 to 22.
//
// R - I is stored rather than R: it is exact where nothing moves.

typedef struct { real w, x, y, z; } quaternion_t;

// R - I of a unit quaternion, Eq. 10.
inline mat rotation_change(quaternion_t q) {
  real x = 2 * q.x, y = 2 * q.y, z = 2 * q.z;
  return (mat){{-(y * q.y + z * q.z), x * q.y - z * q.w, x * q.z + y * q.w,
                x * q.y + z * q.w, -(x * q.x + z * q.z), y * q.z - x * q.w,
                x * q.z - y * q.w, y * q.z + x * q.w, -(x * q.x + y * q.y)}};
}

inline quaternion_t product(quaternion_t a, quaternion_t b) {
  return (quaternion_t){a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
                        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

inline quaternion_t unit4(quaternion_t q) {
  real s = fast_rsqrt(fma(q.w, q.w, fma(q.x, q.x, fma(q.y, q.y, q.z * q.z))));
  return (quaternion_t){s * q.w, s * q.x, s * q.y, s * q.z};
}

inline quaternion_t select4(quaternion_t a, quaternion_t b, integer c) {
  return (quaternion_t){select(a.w, b.w, c), select(a.x, b.x, c), select(a.y, b.y, c),
                        select(a.z, b.z, c)};
}

// S = R^T C.
inline mat rotated_back(const mat *change, const mat *c) {
  mat s;
  UNROLL_ALL for (int i = 0; i < 3; ++i)
    UNROLL_ALL for (int j = 0; j < 3; ++j)
      s.a[3 * i + j] = fma(change->a[i], c->a[j],
                           fma(change->a[3 + i], c->a[3 + j],
                               fma(change->a[6 + i], c->a[6 + j], c->a[3 * i + j])));
  return s;
}

// The vector t with [t]x = S - S^T: the gradient of tr(R^T C) over rotations of R.
inline vec torque_of(const mat *s) {
  return (vec){s->a[7] - s->a[5], s->a[2] - s->a[6], s->a[3] - s->a[1]};
}

// tr(S) I - (S + S^T) / 2, the Hessian of -tr(R^T C): xx, yy, zz, xy, xz, yz.
inline void stiffness_of(const mat *s, real k[6]) {
  k[0] = s->a[4] + s->a[8];
  k[1] = s->a[0] + s->a[8];
  k[2] = s->a[0] + s->a[4];
  k[3] = -0.5f * (s->a[1] + s->a[3]);
  k[4] = -0.5f * (s->a[2] + s->a[6]);
  k[5] = -0.5f * (s->a[5] + s->a[7]);
}

// The inverse of a symmetric matrix xx, yy, zz, xy, xz, yz; 0 where it has none.
inline void invert_symmetric(const real k[6], real inverse[6]) {
  real xx = k[1] * k[2] - k[5] * k[5];
  real xy = k[4] * k[5] - k[3] * k[2];
  real xz = k[3] * k[5] - k[1] * k[4];
  real det = k[0] * xx + k[3] * xy + k[4] * xz;
  real size = fabs(k[0]) + fabs(k[1]) + fabs(k[2]);
  integer singular = fabs(det) <= 1e-9f * size * size * size;
  real scale = select(1 / det, (real)(0), singular | (det == 0));
  inverse[0] = scale * xx;
  inverse[1] = scale * (k[0] * k[2] - k[4] * k[4]);
  inverse[2] = scale * (k[0] * k[1] - k[3] * k[3]);
  inverse[3] = scale * xy;
  inverse[4] = scale * xz;
  inverse[5] = scale * (k[3] * k[4] - k[0] * k[5]);
}

inline vec symmetric_vec(const real k[6], vec v) {
  return (vec){fma(k[0], v.x, fma(k[3], v.y, k[4] * v.z)),
               fma(k[3], v.x, fma(k[1], v.y, k[5] * v.z)),
               fma(k[4], v.x, fma(k[5], v.y, k[2] * v.z))};
}

// The largest root of Eq. 22 for |C| = 1, less 1, by Halley's method.
//
// In cofactors Eq. 22 reads (y^2 - 1)^2 = 4 |cof C|^2 + 8 det(C) y, which keeps its digits where
// the two largest roots meet (control points near a line: both at 1).
inline real largest_root(const mat *c, real *slope) {
  vec r0 = mat_row(c, 0), r1 = mat_row(c, 1), r2 = mat_row(c, 2);
  vec c0 = cross3(r1, r2), c1 = cross3(r2, r0), c2 = cross3(r0, r1);
  real det = dot3(r0, c0), cof2 = dot3(c0, c0) + dot3(c1, c1) + dot3(c2, c2);
  // y^2 = 1 + 2 sqrt(|cof C|^2 + 2 det(C) y). For det(C) > 0, with y by a polynomial of both, the root
  // is off by 0.026 of itself, as a rule by 0.003. Else y^2 <= 1 + 2 sqrt(3) |cof C|: above.
  real y = fma(cof2, fma((real)(-7.9939f), cof2, fma((real)(1.1853f), det, (real)(3.2721f))),
               fma(det, fma((real)(4.7072f), det, (real)(0.7538f)), (real)(1.1042f)));
  real excess = 2 * sqrt(cof2 + select(2 * cof2, 2 * det * y, det > 0));
  // sqrt(1 + excess) - 1 for excess <= 2, within 0.0007 of itself
  real root = excess * fma((real)(0.078658f), excess, (real)(0.49964f)) /
              fma((real)(0.39677f), excess, (real)(1));
  integer moving = (real)(0) == 0;
  *slope = 0;  // it is read before all lanes have set it: compilers may make anything of that
  for (int step = 0; step < 8 && ANY(moving); ++step) {
    real t = root * (root + 2);
    real value = fma(t, t, -4 * fma(2 * det, root + 1, cof2));
    *slope = select(*slope, fma(4 * (root + 1), t, -8 * det), moving);
    real square = *slope * *slope;
    // half the second derivative; all roots are real, so the difference is at least 0.6 squares
    real bend = fma((real)(6), t, (real)(4));
    real divisor = fast_max(fma(-value, bend, square), 0.5f * square);
    real change = select((real)(0), value * *slope / divisor, moving & (*slope >= 1e-12f));
    root -= change;
    moving &= fabs(change) > 1e-2f * root;  // else the next one is below 1e-6 of the root
  }
  return root;
}

// The unit eigenvector of Horn's symmetric 4x4 matrix `a` (00 11 22 33 01 02 03 12 13 23) for its
// eigenvalue 1 + root: the largest column of the adjugate.
inline quaternion_t eigenvector(const real a[10], real root) {
  real a00 = a[0] - 1 - root, a11 = a[1] - 1 - root, a22 = a[2] - 1 - root, a33 = a[3] - 1 - root;
  real a01 = a[4], a02 = a[5], a03 = a[6], a12 = a[7], a13 = a[8], a23 = a[9];
  // 2x2 minors of rows 2 and 3, and of rows 0 and 1
  real m01 = a02 * a13 - a12 * a03, m02 = a02 * a23 - a22 * a03, m03 = a02 * a33 - a23 * a03,
       m12 = a12 * a23 - a22 * a13, m13 = a12 * a33 - a23 * a13, m23 = a22 * a33 - a23 * a23;
  real n01 = a00 * a11 - a01 * a01, n02 = a00 * a12 - a02 * a01, n03 = a00 * a13 - a03 * a01,
       n12 = a01 * a12 - a02 * a11, n13 = a01 * a13 - a03 * a11, n23 = a02 * a13 - a03 * a12;
  real d00 = a11 * m23 - a12 * m13 + a13 * m12, d11 = a00 * m23 - a02 * m03 + a03 * m02,
       d22 = a03 * n13 - a13 * n03 + a33 * n01, d33 = a02 * n12 - a12 * n02 + a22 * n01;
  real d01 = -(a01 * m23 - a12 * m03 + a13 * m02), d02 = a01 * m13 - a11 * m03 + a13 * m01,
       d03 = -(a01 * m12 - a11 * m02 + a12 * m01), d12 = -(a00 * m13 - a01 * m03 + a03 * m01),
       d13 = a00 * m12 - a01 * m02 + a02 * m01, d23 = -(a03 * n12 - a13 * n02 + a23 * n01);
  quaternion_t q = {d00, d01, d02, d03};
  real best = fabs(d00);
  integer better = fabs(d11) > best;
  best = fast_max(best, fabs(d11));
  q = select4(q, (quaternion_t){d01, d11, d12, d13}, better);
  better = fabs(d22) > best;
  best = fast_max(best, fabs(d22));
  q = select4(q, (quaternion_t){d02, d12, d22, d23}, better);
  better = fabs(d33) > best;
  best = fast_max(best, fabs(d33));
  q = select4(q, (quaternion_t){d03, d13, d23, d33}, better);
  integer none = best < 1e-18f;
  q.w = select(q.w, (real)(1), none);
  return unit4(q);
}

// Best twist about the longest axis of C. Near a line the other methods hardly determine the twist, and
// may turn it by 180 degrees; about a given axis the optimum is explicit.
inline quaternion_t twisted(quaternion_t q, const mat *c) {
  mat change = rotation_change(q);
  mat s = rotated_back(&change, c);
  vec t = torque_of(&s);
  real off01 = s.a[1] + s.a[3], off02 = s.a[2] + s.a[6], off12 = s.a[5] + s.a[7];
  vec axis = {2 * s.a[0], off01, off02};
  real best = s.a[0];
  integer better = s.a[4] > best;
  best = fast_max(best, s.a[4]);
  axis = vec_select(axis, (vec){off01, 2 * s.a[4], off12}, better);
  better = s.a[8] > best;
  axis = unit3(vec_select(axis, (vec){off02, off12, 2 * s.a[8]}, better));
  real k[6];
  stiffness_of(&s, k);
  // (cosine, sine) of the angle, up to a factor
  real cosine = dot3(axis, symmetric_vec(k, axis)), sine = dot3(axis, t);
  real length = sqrt(fma(cosine, cosine, sine * sine));
  // half the angle: (1 + cos, sin), or (|sin|, 1 - cos) where that is larger
  real w = select(fabs(sine), length + cosine, cosine >= 0);
  real rotated = select(copysign(length - cosine, sine), sine, cosine >= 0);
  integer none = length < 1e-20f;
  w = select(w, (real)(1), none);
  rotated = select(rotated, (real)(0), none);
  return unit4(product(q, (quaternion_t){w, rotated * axis.x, rotated * axis.y, rotated * axis.z}));
}

// One Newton step on the rotations, where it is safe.
inline quaternion_t polished(quaternion_t q, const mat *c) {
  mat change = rotation_change(q);
  mat s = rotated_back(&change, c);
  real k[6], inverse[6];
  stiffness_of(&s, k);
  invert_symmetric(k, inverse);
  vec halved = vec_scale((real)(0.5f), symmetric_vec(inverse, torque_of(&s)));
  integer far = dot3(halved, halved) > 0.1f;
  halved = vec_select(halved, (vec){0, 0, 0}, far);
  return unit4(product(q, (quaternion_t){1, halved.x, halved.y, halved.z}));
}

// Below this distance to other roots (near a line, or a reflection), the eigenvector is refined.
#define CLOSE_ROOTS 0.5f

// The whole rotation, from a C of any size; the distance to other roots.
inline quaternion_t whole_rotation(const mat *covariance, real *slope) {
  const vec r0 = mat_row(covariance, 0), r1 = mat_row(covariance, 1), r2 = mat_row(covariance, 2);
  real square = dot3(r0, r0) + dot3(r1, r1) + dot3(r2, r2);
  real scale = select(fast_rsqrt(square), (real)(0), square < 1e-36f);
  mat c;
  UNROLL_ALL for (int i = 0; i < 9; ++i) c.a[i] = scale * covariance->a[i];
  real a[10] = {c.a[0] + c.a[4] + c.a[8], c.a[0] - c.a[4] - c.a[8], c.a[4] - c.a[0] - c.a[8],
                c.a[8] - c.a[0] - c.a[4], c.a[7] - c.a[5], c.a[2] - c.a[6],
                c.a[3] - c.a[1],          c.a[1] + c.a[3], c.a[2] + c.a[6],
                c.a[5] + c.a[7]};
  quaternion_t q = eigenvector(a, largest_root(&c, slope));
  integer close = *slope < CLOSE_ROOTS;
  if (ANY(close)) q = select4(q, polished(twisted(q, &c), &c), close);
  return q;
}

// The reflection that takes `a` to the x axis: its normal, length sqrt(2).
inline vec mirror_of(vec a) {
  vec normal = {a.x + copysign(sqrt(dot3(a, a)), a.x), a.y, a.z};
  return vec_scale(sqrt(2 / fast_max(dot3(normal, normal), 1e-30f)), normal);
}

inline vec mirrored(vec normal, vec a) { return vec_madd(-dot3(normal, a), normal, a); }

// The rotation between two reflections.
inline quaternion_t unmirrored(vec p_normal, quaternion_t r, vec q_normal) {
  quaternion_t a = {0, p_normal.x, p_normal.y, p_normal.z};
  quaternion_t b = {0, q_normal.x, q_normal.y, q_normal.z};
  return unit4(product(product(a, r), b));
}

// The line of a C = s a b^T of rank 1: unit vectors with q along b and p along a.
inline void line_of(const mat *c, vec *a, vec *b) {
  vec row = mat_row(c, 0);
  real best = dot3(row, row);
  for (int i = 1; i < 3; ++i) {
    vec other = mat_row(c, i);
    real square = dot3(other, other);
    row = vec_select(row, other, square > best);
    best = fast_max(best, square);
  }
  *b = unit3(row);
  *a = unit3(mat_vec(c, *b));
}

// The twist-free rotation that turns b to a.
inline quaternion_t line_rotation(vec a, vec b, float4 flip_axis) {
  vec halved = vec_add(a, b);
  integer opposite = dot3(halved, halved) < 1e-10f;
  halved = unit3(halved);
  vec axis = cross3(b, halved);
  quaternion_t q = {dot3(halved, b), axis.x, axis.y, axis.z};
  q = select4(q, (quaternion_t){0, flip_axis.x, flip_axis.y, flip_axis.z}, opposite);
  return unit4(select4(q, (quaternion_t){1, 0, 0, 0}, dot3(a, a) < 0.5f));
}
