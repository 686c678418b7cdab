// The weights of Eq. 2 and 27: c_i / (|q_i - v|^2 + s^2)^alpha, for every power and distance in
// float32. The smoothing length s is 0 in the paper.
//
// All distances are damped ones: a control point behind a cut counts as farther away. k is the control
// point nearest to v, e the distance of the second nearest. The other control points are summed with
// weights (e / d_i)^(2 alpha) <= 1, which never overflow; r = (d_k / e)^(2 alpha) relates them to the
// weight of k. Coordinates are relative to k: k adds to the total weight only, and r = 0 (v on a
// control point) is exact.

// Build constants: CUTS, AT_REST, REGIONS, SEGMENTS, STEPS, TWICE_ALPHA.

// The map of a region. `kind_table` is that of `Kind.table`.
typedef struct {
  map_params_t params;
  __global const control_point_t *control_points;
  __global const float *kind_table;
  __global const region_t *regions;
  __global const segment_t *segments;
  __global const limit_t *limits;
  __global const float *images;
  __global const step_t *steps;
  cuts_t cuts;
  __global const control_point_t *rest_control_points;  // of the first step, which begins at rest
  __global const segment_t *rest_segments;
} map_t;

// The first arguments of each kernel of the map; then those of kernels at points, float in three planes.
#define MAP_ARGUMENTS                                                       \
  const map_params_t map_params, __global const float *restrict map_tables, \
      const cut_params_t cut_params, __global const float *restrict cut_tables
#define THE_MAP map_of(map_params, map_tables, cut_params, cut_tables)
#define POINT_ARGUMENTS const long points_count, __global const float *restrict points

// The map of a launch; `cut_tables` is null without cuts. Of several steps it is the first, from which
// `step_of` finds the others.
inline map_t map_of(const map_params_t params, __global const float *map_tables,
                    const cut_params_t cut_params, __global const float *cut_tables) {
  map_t map;
  map.params = params;
  map.control_points = (__global const control_point_t *)map_tables;
  map.kind_table = map_tables + params.kind_start;
  map.regions = (__global const region_t *)(map_tables + params.region_start);
  map.segments = (__global const segment_t *)(map_tables + params.segment_start);
  map.limits = (__global const limit_t *)(map_tables + params.limit_start);
  map.images = map_tables + params.image_start;
  map.steps = (__global const step_t *)(map_tables + params.step_start);
  map.cuts = cuts_of(cut_params, (__global const plane_t *)cut_tables,
                     cut_tables + cut_params.obstacle_start);
  map.rest_control_points = map.control_points;
  map.rest_segments = map.segments;
  return map;
}

#include REGION_FILE
#include SEGMENT_FILE

// Control points whose squared distances are kept between the two passes over them, of segments their
// damping; a GPU has too few registers.
#define CACHED (LANES > 1 ? CACHED_BY_CUTS : 0)
#define CACHE_SIZE (CACHED > 0 ? CACHED : 1)

// The steps of a map before the last one evaluated: where they began, their displacements together, and
// for cuts in the deformed frame the smallest void distance.
typedef struct {
  vec start, moved;
  real void_distance;
} steps_done_t;

// A point at which the map is evaluated, with the values that are used again.
typedef struct {
  vec v;
  view_t view;
  steps_done_t steps;
  real distance2[CACHE_SIZE];
  cached_segments_t segments;
} evaluation_point_t;

// Sets the evaluation point v; in the rest frame cuts see from `origin`, else from v = `origin`.
inline void set_point(const cuts_t *cuts, evaluation_point_t *point, vec v, vec origin) {
  point->v = v;
  set_view(cuts, &point->view, origin);
}

// Terms of the sums: control points, then segments of curves.
inline int term_count(const map_t *map) {
  return SEGMENTS ? map->params.count + map->params.segment_count : map->params.count;
}

// Whether term i is a segment.
inline int is_segment(const map_t *map, int i) { return SEGMENTS && i >= map->params.count; }

// Terms are summed in blocks, then the blocks: rounding grows with the fourth root of their number.
inline int block_of(const map_t *map) { return max(16, (int)sqrt((float)term_count(map))); }

// The pivot: all sums at v are relative to it.
typedef struct {
  integer k;  // nearest term
  vec q;      // q_k, of a segment its point nearest to v, of a region its mean
  vec x;      // v - q_k
  vec u;      // p_k - q_k - mean displacement
  real c;     // its weight factor, 0 for a segment
  real d2;    // its damped squared distance
  real e2;    // squared distance of the second nearest
  real r;     // (d_k / e)^(2 alpha), 1 for a segment or a region
  real t;     // of a segment the share of its length at q_k
} pivot_t;

inline __global const control_point_t *control_point_of(const map_t *map, int i) {
  return map->control_points + i;
}

// Whether term i is a rigid region: all its proxies.
inline int is_region(const map_t *map, int i) { return REGIONS && i < map->params.region_count; }

// |q - v|^2 + `smoothing2`.
inline real straight_distance2(__global const control_point_t *at, vec v, float smoothing2) {
  real dx = at->q[0] - v.x, dy = at->q[1] - v.y, dz = at->q[2] - v.z;
  return fma(dx, dx, fma(dy, dy, fma(dz, dz, (real)(smoothing2))));
}

inline __global const segment_t *segment_of(const map_t *map, int i) {
  return map->segments + i - map->params.count;
}

// The middle of segment i as cuts see it.
inline vec segment_target(const map_t *map, int i) {
  __global const segment_t *along =
      (AT_REST && STEPS ? map->rest_segments : map->segments) + i - map->params.count;
  const vec middle = vec_madd(0.5f, load3(along->along_q), load3(along->q));
  if (!AT_REST) return middle;
  const vec u = vec_madd(0.5f, load3(along->along_u), load3(along->u));
  return vec_add(middle, vec_add(u, mean_displacement_of(&map->cuts)));
}

// Where cuts see a term: at p if they belong to the material, else at q; a segment in its middle.
inline vec cut_target(const map_t *map, int i) {
  if (is_segment(map, i)) return segment_target(map, i);
  if (is_region(map, i)) return load3(map->regions[i].anchor);
  __global const control_point_t *at =
      AT_REST && STEPS ? map->rest_control_points + i : control_point_of(map, i);
  if (!AT_REST) return load3(at->q);
  return origin_of(&map->cuts, load3(at->q), load3(at->u));
}

HOT real control_point_distance2(const map_t *map, int i, const int of_region,
                                 const evaluation_point_t *point, integer *hides_any) {
  __global const control_point_t *at = control_point_of(map, i);
  real d2;
  if (of_region)
    d2 = distance_from_region(map->regions + i, map->images, point->v, 0).square;
  else
    d2 = straight_distance2(at, point->v, map->params.smoothing2);
  if (!CUTS) return d2;
  return damped_distance2(&map->cuts, &point->view, i, cut_target(map, i), d2, hides_any);
}

// v relative to segment i, after `find_pivot`.
HOT nearest_t found_on_segment(const map_t *map, int i, const evaluation_point_t *point) {
  __global const segment_t *at = segment_of(map, i);
  const int s = i - map->params.count;
  if (s < CACHED_SEGMENTS)
    return nearest_by_projection(at, point->segments.projection[s], point->segments.off2[s]);
  return nearest_on_segment(at, point->v);
}

// The factor of the squared distance of segment i by cuts; `UNREACHABLE` and more behind closed ones.
HOT real segment_damping(const map_t *map, int i, const evaluation_point_t *point,
                         integer *hides_any) {
  if (!CUTS) return 1;
  return damped_distance2(&map->cuts, &point->view, i, cut_target(map, i), (real)(1), hides_any);
}

// Weights are relative to at least this squared distance where the nearest is a segment.
#define MIN_SECOND 1e-4f

// Makes the nearest points of segments the pivot, at the shares `t` of their lengths.
inline void pivot_on_segments(const map_t *map, real t, integer on_segment, pivot_t *pivot) {
  vec q = pivot->q, along_q = {0, 0, 0}, u = pivot->u, along_u = {0, 0, 0};
  for (int l = 0; l < LANES; ++l) {
    if (!LANE_INT(on_segment, l)) continue;
    __global const segment_t *at = segment_of(map, LANE_INT(pivot->k, l));
    set_lane(&q, l, vload3(0, at->q));
    set_lane(&u, l, vload3(0, at->u));
    set_lane(&along_q, l, vload3(0, at->along_q));
    set_lane(&along_u, l, vload3(0, at->along_u));
  }
  pivot->t = t;
  pivot->q = vec_madd(t, along_q, q);
  pivot->u = vec_madd(t, along_u, u);
  pivot->c = select(pivot->c, (real)(0), on_segment);
}

// Sets the values of the control points k of the lanes.
HOT void set_nearest(pivot_t *pivot, const map_t *map, integer k) {
  __global const control_point_t *nearest = control_point_of(map, LANE_INT(k, 0));
  pivot->q = load3(nearest->q);
  pivot->c = nearest->c;
  pivot->u = load3(nearest->u);
  if (!ANY(k != LANE_INT(k, 0))) return;  // neighbors mostly share their nearest control point
  for (int l = 1; l < LANES; ++l) {
    nearest = control_point_of(map, LANE_INT(k, l));
    set_lane(&pivot->q, l, vload3(0, nearest->q));
    LANE(pivot->c, l) = nearest->c;
    set_lane(&pivot->u, l, vload3(0, nearest->u));
  }
}

// The nearest term k, and the squared distances of it and of the second nearest.
typedef struct {
  integer k;
  real first, second;
} nearest_two_t;

// Updates the nearest terms by term i; returns whether it is the nearest so far.
HOT integer update_nearest(nearest_two_t *two, int i, real d2) {
  const integer nearer = d2 < two->first;
  two->k = select(two->k, (integer)(i), nearer);
  two->second = fast_min(two->second, fast_max(two->first, d2));
  two->first = fast_min(two->first, d2);
  return nearer;
}

// A region is also its own second nearest: each of its proxies is as near.
HOT void update_by_control_point(nearest_two_t *two, const map_t *map, int i, const int of_region,
                               evaluation_point_t *point, integer *hides_any) {
  const real d2 = control_point_distance2(map, i, of_region, point, hides_any);
  update_nearest(two, i, d2);
  if (of_region) two->second = fast_min(two->second, d2);
  if (i < CACHED) point->distance2[i] = d2;
}

// Updates the nearest terms by the segments, and t by the share of the length at the nearest one.
HOT void update_by_segments(nearest_two_t *two, real *t, const map_t *map, evaluation_point_t *point,
                            integer *hides_any) {
  for (int i = map->params.count; i < term_count(map); ++i) {
    const nearest_t nearest = nearest_on_segment(segment_of(map, i), point->v);
    const int s = i - map->params.count;
    if (s < CACHED_SEGMENTS) {
      point->segments.projection[s] = nearest.projection;
      point->segments.off2[s] = nearest.off2;
    }
    const real damping = segment_damping(map, i, point, hides_any);
    real damped = (nearest.d2 + map->params.smoothing2) * damping;
    if (CUTS) damped = select(damped, (real)(2 * UNREACHABLE), is_unreachable(damping));
    *t = select(*t, nearest.t, update_nearest(two, i, damped));
    if (CUTS && i < CACHED) point->distance2[i] = damping;
  }
}

inline pivot_t find_pivot(const map_t *map, evaluation_point_t *point) {
  nearest_two_t two = {0, FLT_MAX, FLT_MAX};
  integer hides_any = 0;
  real t = 0;
  int i = 0;
  for (; is_region(map, i); ++i) update_by_control_point(&two, map, i, 1, point, &hides_any);
  for (; i < map->params.count; ++i)
    update_by_control_point(&two, map, i, 0, point, &hides_any);
  if (SEGMENTS) update_by_segments(&two, &t, map, point, &hides_any);
  set_hiding(&point->view, hides_any);
  const integer on_segment = SEGMENTS ? two.k >= map->params.count : (integer)(0);
  pivot_t pivot;
  pivot.k = two.k;
  set_nearest(&pivot, map, SEGMENTS ? select(two.k, (integer)(0), on_segment) : two.k);
  if (SEGMENTS && ANY(on_segment)) pivot_on_segments(map, t, on_segment, &pivot);
  pivot.x = vec_sub(point->v, pivot.q);
  pivot.d2 = two.first;
  pivot.e2 = fast_max(two.second, 1e-30f);
  pivot.r = power(two.first / pivot.e2, map->params.alpha);
  if (SEGMENTS) {
    const real second = fast_max(fast_min(two.second, (real)(1e6f)), (real)(MIN_SECOND));
    pivot.e2 = select(pivot.e2, second, on_segment);
    pivot.r = select(pivot.r, (real)(1), on_segment);
  }
  return pivot;
}

// Weight of a control point next to the others but k; of a region that of all its proxies.
HOT real control_point_weight(const map_t *map, int i, const pivot_t *pivot,
                                 const evaluation_point_t *point) {
  integer hides_any = 0;
  real d2 = i < CACHED ? point->distance2[i]
                       : control_point_distance2(map, i, is_region(map, i), point, &hides_any);
  real w = control_point_of(map, i)->c *
           power(pivot->e2 / fast_max(d2, pivot->e2), map->params.alpha);
  return CUTS ? select(w, (real)(0), is_unreachable(d2)) : w;
}

// d log(w_i)/dv of a control point or a region, without damping.
inline vec distance_slope(const map_t *map, int i, const evaluation_point_t *point) {
  __global const control_point_t *at = control_point_of(map, i);
  real d2 = straight_distance2(at, point->v, map->params.smoothing2);
  vec to = vec_sub(load3(at->q), point->v);
  if (is_region(map, i)) {
    const region_distance_t distance =
        distance_from_region(map->regions + i, map->images, point->v, 1);
    d2 = distance.square;
    to = vec_scale((real)(-1), distance.outward);
  }
  return vec_scale(2 * map->params.alpha / fast_max(d2, 1e-30f), to);
}

// d log(w_i)/dx for the origin x of the material, in the rest frame; else the part of the damping in
// d log(w_i)/dv.
inline vec origin_slope(const map_t *map, int i, const evaluation_point_t *point) {
  return damping_slope(&map->cuts, &point->view, i, cut_target(map, i));
}

// d log(w_i)/dv; of a segment by the damping alone.
inline vec weight_slope(const map_t *map, int i, const evaluation_point_t *point) {
  const vec none = {0, 0, 0};
  const vec slope = is_segment(map, i) ? none : distance_slope(map, i, point);
  return CUTS && !AT_REST ? vec_add(slope, origin_slope(map, i, point)) : slope;
}

// The slope of the weight of k by v, or by the origin x.
inline vec slope_of_nearest(const map_t *map, const pivot_t *pivot, const evaluation_point_t *point,
                            const int by_origin) {
  vec slope = {0, 0, 0};
  for (int i = 0; i < term_count(map); ++i)
    if (ANY(pivot->k == i))  // as a rule once
      slope = vec_select(
          slope, by_origin ? origin_slope(map, i, point) : weight_slope(map, i, point), pivot->k == i);
  return slope;
}

// The slope of the pivot's weight by v, which is subtracted from all slopes: a common factor of all
// weights has no effect.
inline vec pivot_slope(const map_t *map, const pivot_t *pivot, const evaluation_point_t *point) {
  if (REGIONS || SEGMENTS || (CUTS && !AT_REST)) return slope_of_nearest(map, pivot, point, 0);
  // in the rest frame pivot->d2 is longer where a cut hides k
  const real d2 = AT_REST ? dot3(pivot->x, pivot->x) + map->params.smoothing2 : pivot->d2;
  return vec_scale(-2 * map->params.alpha / fast_max(d2, 1e-30f), pivot->x);
}

// Change of the fit with the weights: by v, and in the rest frame of cuts by the origin x, from which
// the cuts see the control points. `near` and `near_x` are the slopes of the pivot's weight.
typedef struct {
  mat d_dv;
  vec near;
  mat d_dx;
  vec near_x;
} weight_jacobian_t;

inline weight_jacobian_t no_weight_jacobian(const map_t *map, const pivot_t *pivot,
                                            const evaluation_point_t *point) {
  weight_jacobian_t jacobian;
  jacobian.d_dv = jacobian.d_dx = (mat){{0}};
  jacobian.near = pivot_slope(map, pivot, point);
  jacobian.near_x = (vec){0, 0, 0};
  if (AT_REST) jacobian.near_x = slope_of_nearest(map, pivot, point, 1);
  return jacobian;
}
