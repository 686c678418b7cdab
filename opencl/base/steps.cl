// A map of several steps: G = G_1 o ... o G_N. Step k leads from stage k to stage k - 1. All steps have
// the local frame of the whole, without a mean displacement.
//
// Build constants: CUTS, AT_REST.

// Step k of a map, as a map of one step.
inline map_t step_of(const map_t *map, int k) {
  __global const step_t *at = map->steps + k;
  map_t step = *map;
  step.params.step_count = 1;
  step.params.rank = at->rank;
  for (int axis = 0; axis < 3; ++axis) step.params.flip_axis[axis] = at->flip_axis[axis];
  step.control_points += at->control_point;
  step.kind_table += at->kind_value;
  step.regions += at->region;
  step.segments += at->segment;
  step.cuts = cuts_of_step(&map->cuts, k);
  return step;
}

// Sets the point v at which step `map` is evaluated. In the rest frame cuts see from the origin in all
// steps.
inline void set_step_point(const map_t *map, evaluation_point_t *point, vec v) {
  point->v = v;
  if (!AT_REST) set_view(&map->cuts, &point->view, v);
}

// Fits the steps at fit->point, last to first; the fit is that of the first step then.
inline void fit_map(const map_t *map, fit_t *fit) {
  evaluation_point_t *point = &fit->point;
  steps_done_t done = {point->v, {0, 0, 0}, FLT_MAX};
  for (int k = map->params.step_count - 1; k >= 0; --k) {
    const map_t step = k > 0 ? step_of(map, k) : *map;
    set_step_point(&step, point, vec_add(done.start, done.moved));
    fit_step(&step, fit);
    if (k == 0) break;
    const vec d = step_displacement(&step, fit);
    done.moved = vec_add(done.moved, d);
    if (CUTS && !AT_REST && !regions_compete(&map->cuts)) {  // cuts that stay may be crossed in any
      const real distance =
          void_distance_of(&step.cuts, point->v, vec_add(point->v, d), (integer)(0));
      done.void_distance = fast_min(done.void_distance, distance);
    }
  }
  point->steps = done;
}

inline vec start_of(const fit_t *fit) { return fit->point.steps.start; }

// G(v) - v.
inline vec map_displacement(const map_t *map, const fit_t *fit) {
  return vec_add(fit->point.steps.moved, step_displacement(map, fit));
}

// (I + a) (I + b) - I.
inline mat mat_composed(const mat *a, const mat *b) {
  mat c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const real product = dot3(mat_row(a, i), mat_column(b, j));
      c.a[3 * i + j] = a->a[3 * i + j] + b->a[3 * i + j] + product;
    }
  return c;
}

// The Jacobians of all steps by the chain rule. The steps are fitted again, because a work item cannot
// store their fits. `least_determinant` becomes the smallest determinant of a step.
inline weight_jacobian_t composed_jacobian(const map_t *map, const fit_t *fit,
                                           real *least_determinant) {
  fit_t at;
  at.point = fit->point;
  vec v = start_of(fit);
  weight_jacobian_t total;
  total.d_dv = total.d_dx = (mat){{0}};
  *least_determinant = FLT_MAX;
  for (int k = map->params.step_count - 1; k >= 0; --k) {
    const map_t step = k > 0 ? step_of(map, k) : *map;
    set_step_point(&step, &at.point, v);
    fit_step(&step, &at);
    v = vec_add(v, step_displacement(&step, &at));
    const weight_jacobian_t jacobian = step_jacobian(&step, &at);
    *least_determinant = fast_min(*least_determinant, determinant_of(&jacobian.d_dv));
    total.d_dv = mat_composed(&jacobian.d_dv, &total.d_dv);
    if (!AT_REST) continue;
    // (I + A) B + C = (I + A) (I + B) - I - A + C
    total.d_dx = mat_composed(&jacobian.d_dv, &total.d_dx);
    for (int i = 0; i < 9; ++i) total.d_dx.a[i] += jacobian.d_dx.a[i] - jacobian.d_dv.a[i];
  }
  return total;
}
