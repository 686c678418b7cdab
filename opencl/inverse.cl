// The inverse of the backward map: v with G(v) = x, by Newton's method with step control.

#define NEWTON_STEPS 40
#define HALVINGS 6
#define INVERSE_TOLERANCE 3e-7f  // local units: about what float32 resolves

// d with (I + J) d = r for the Jacobian J of the displacement; r itself where I + J is singular.
inline vec newton_step(const mat *jacobian, vec r) {
  vec a = {1 + jacobian->a[0], jacobian->a[1], jacobian->a[2]};
  vec b = {jacobian->a[3], 1 + jacobian->a[4], jacobian->a[5]};
  vec c = {jacobian->a[6], jacobian->a[7], 1 + jacobian->a[8]};
  vec bc = cross3(b, c), ca = cross3(c, a), ab = cross3(a, b);
  real det = dot3(a, bc);
  vec step = vec_madd(r.x, bc, vec_madd(r.y, ca, vec_scale(r.z, ab)));
  integer singular = fabs(det) < 1e-6f;
  return vec_select(vec_scale(1 / select(det, (real)(1), singular), step), r, singular);
}

// Improves `v` until G(v) = x; the distance that is left of G(v) from x, local units. `x` is less
// drift.
inline real invert(const map_t *map, vec x, vec *v) {
  fit_t fit = fit_at(map, *v);
  vec r = vec_sub(x, vec_add(*v, moved(map, &fit)));
  real left = sqrt(dot3(r, r));
  for (int step = 0; step < NEWTON_STEPS; ++step) {
    if (!ANY(left > INVERSE_TOLERANCE)) break;
    mat jacobian = moved_jacobian(map, &fit);
    vec way = newton_step(&jacobian, r);
    real share = 1;
    integer open = left > INVERSE_TOLERANCE;
    for (int half_step = 0; half_step < HALVINGS && ANY(open); ++half_step) {
      vec next = vec_madd(share, way, *v);
      fit_t there = fit_at(map, next);
      vec rest = vec_sub(x, vec_add(next, moved(map, &there)));
      real distance = sqrt(dot3(rest, rest));
      integer better = open & (distance < left);
      *v = vec_select(*v, next, better);
      r = vec_select(r, rest, better);
      left = select(left, distance, better);
      open &= !better;
      share = select(share, share * 0.5f, open);
    }
    if (ALL(open | (left <= INVERSE_TOLERANCE))) break;  // nobody moves any more
    fit = fit_at(map, *v);
  }
  return left;
}
