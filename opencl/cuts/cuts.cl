// Cuts (section 4): the damping of Eq. 28, and the void. Rules of the shapes: vtk_mls/model/cuts.
//
// Full planes are no obstacles here: the host gives each of their sides its own control points, and a
// launch computes the points of one side (`in_region`). SHAPES(X) expands to X(shape) for each other
// shape of the deformation; each has a table of cuts.
//
// Build constants: SHAPE_FILES, SHAPES(X), AT_REST, those of the shapes.

#define SHAPE_TABLE(shape) __global const float *shape;
typedef struct {
  cut_params_t params;
  __global const plane_t *planes;
  __global const float *obstacles;  // start of the table of each shape, then the tables
  SHAPES(SHAPE_TABLE)
} cuts_t;

inline cuts_t cuts_of(const cut_params_t params, __global const plane_t *planes,
                      __global const float *obstacles) {
  cuts_t cuts;
  int shape_index = 0;
  cuts.params = params;
  cuts.planes = planes;
  cuts.obstacles = obstacles;
#define SET_TABLE(shape) cuts.shape = obstacles + as_int(obstacles[shape_index++]);
  SHAPES(SET_TABLE)
  return cuts;
}

// The cuts as step k sees them.
inline cuts_t cuts_of_step(const cuts_t *cuts, int k) {
  return cuts_of(cuts->params, cuts->planes, cuts->obstacles + k * cuts->params.obstacle_stride);
}

// A table of cuts: number of cuts, start of each record, the records.
inline int count_of(__global const float *table) { return as_int(table[0]); }
inline __global const float *record_of(__global const float *table, int i) {
  return table + as_int(table[1 + i]);
}

inline real distance3(vec a, vec b) {
  vec d = vec_sub(a, b);
  return sqrt(dot3(d, d));
}

// The functions of a shape that uses points as they are and caches nothing (README.md, Cut shapes).
#define PLAIN_POINTS(shape)                                                                       \
  typedef vec shape##_point_t;                                                                    \
  typedef vec shape##_cache_t;                                                                    \
  inline int shape##_count(__global const float *table) { return count_of(table); }               \
  inline vec shape##_point(__global const float *cut, vec x) { return x; }                        \
  inline vec shape##_cache(__global const float *table, vec v) { return v; }                      \
  inline vec shape##_cached(const vec *cache, int i) { return *cache; }                           \
  inline vec shape##_control_point(__global const float *cut, int k, vec q) { return q; }         \
  inline real shape##_distance2(vec a, vec b) { return dot3(vec_sub(a, b), vec_sub(a, b)); }

#define NO_DETOUR -1.0f

// Squared distances from here on are those of control points that a closed surface separates from v.
#define UNREACHABLE 1e29f
inline integer is_unreachable(real d2) { return d2 >= UNREACHABLE; }

#include SHAPE_FILES

inline real plane_height(const float4 plane, vec x) {
  return fma(plane.x, x.x, fma(plane.y, x.y, fma(plane.z, x.z, (real)(plane.w))));
}

// Whether the grid point `index` is on this launch's side of all planes. Indices are the same floats in
// every launch, so each point belongs to exactly one launch.
inline integer in_region(const cuts_t *cuts, vec index) {
  integer inside = (real)(0) == 0;
  for (int i = 0; i < cuts->params.plane_count; ++i) {
    integer below = plane_height(vload4(0, cuts->planes[i].index_plane), index) < 0;
    inside &= cuts->planes[i].side < 0 ? below : !below;
  }
  return inside;
}

// Whether cells of `step` points, the first of them `index`, may have points on this launch's side of all
// planes: with a margin of one point, so that rounding loses none.
inline integer may_be_in_region(const cuts_t *cuts, vec index, int step) {
  integer inside = (real)(0) == 0;
  for (int i = 0; i < cuts->params.plane_count; ++i) {
    const float4 plane = vload4(0, cuts->planes[i].index_plane);
    const float side = cuts->planes[i].side;
    const float reach = fabs(plane.x) + fabs(plane.y) + fabs(plane.z) +
                        step * (fmax(side * plane.x, 0) + fmax(side * plane.y, 0) +
                                fmax(side * plane.z, 0));
    inside &= side * plane_height(plane, index) + reach >= 0;
  }
  return inside;
}

// Whether a local x is on this launch's side of all planes, or on one; rounding is relative to `size`.
inline integer on_side(const cuts_t *cuts, vec x, real size) {
  integer inside = (real)(0) == 0;
  for (int i = 0; i < cuts->params.plane_count; ++i) {
    real height = plane_height(vload4(0, cuts->planes[i].plane), x);
    inside &= cuts->planes[i].side * height >= -cuts->params.on_plane * size;
  }
  return inside;
}

inline vec mean_displacement_of(const cuts_t *cuts) {
  const float *mean_displacement = cuts->params.mean_displacement;
  return (vec){mean_displacement[0], mean_displacement[1], mean_displacement[2]};
}

// Local origin of the material at v, for its displacement d less the mean displacement.
inline vec origin_of(const cuts_t *cuts, vec v, vec d) {
  return vec_add(vec_add(v, d), mean_displacement_of(cuts));
}

// Runs `statement` for each `cut` of a shape, and counts the cuts of all shapes.
#define FOR_EACH_CUT(shape, statement)                                                            \
  for (int i = 0; i < shape##_count(cuts->shape); ++i, ++cut_index) {                             \
    __global const float *cut = record_of(cuts->shape, i);                                        \
    statement                                                                                     \
  }

// The obstacles between v and g: bit i for cut i.
inline integer crossed(const cuts_t *cuts, vec v, vec g) {
  integer bits = 0;
  int cut_index = 0;
#define CROSS(shape)                                                                              \
  FOR_EACH_CUT(shape,                                                                             \
               integer between = shape##_blocks(cut, shape##_point(cut, v), shape##_point(cut, g)); \
               bits |= select((integer)(0), (integer)(1 << cut_index), between);)
  SHAPES(CROSS)
  return bits;
}

// Whether an obstacle is between v and g.
inline integer blocked(const cuts_t *cuts, vec v, vec g) { return crossed(cuts, v, g) != 0; }

// Control points whose damped squared distances are cached.
#define CACHED_BY_CUTS 64

// The point from which cuts see, and the values of it that they reuse.
#define SHAPE_CACHE(shape) shape##_cache_t shape;
typedef struct {
  vec from;              // v, or in the rest frame the origin of the material
  integer crossed_cuts;  // bit i: the material is behind cut i, but as if in front (rest_frame.cl)
  integer hides_any;     // whether a cut hides any control point
  SHAPES(SHAPE_CACHE)
} view_t;

inline void set_view(const cuts_t *cuts, view_t *view, vec from) {
  view->from = from;
  view->crossed_cuts = view->hides_any = (integer)(0);
#define SET_CACHE(shape) view->shape = shape##_cache(cuts->shape, from);
  SHAPES(SET_CACHE)
}

// Whether cut `cut_index` counts as in front of the viewpoint while it is behind, or the reverse.
inline integer is_exchanged(integer crossed_cuts, int cut_index) {
  return AT_REST ? (crossed_cuts & (1 << cut_index)) != 0 : (integer)(0);
}

// ratio^damping; the common powers, nu / alpha = 2, 3 and 4, without logarithms.
inline real to_damping(real ratio, float damping) {
  if (damping == 1) return ratio;
  if (damping == 1.5f) return ratio * sqrt(ratio);
  if (damping == 2) return ratio * ratio;
  return fast_exp2(damping * fast_log2(ratio));
}

// The cuts between v and a control point: their effect on the squared distance.
typedef struct {
  real ratio;  // product of (detour / distance)^2
  integer any, unreachable;
} detours_t;

inline void add_detour(detours_t *detours, integer blocked, real length2, real d2) {
  real longer = fast_max(length2 / fast_max(d2, 1e-30f), (real)(1));
  detours->ratio = select(detours->ratio, detours->ratio * longer, blocked);
  detours->any |= blocked;
  detours->unreachable |= blocked & (length2 < 0);
}

// Runs `statement` for each cut that blocks the segment from the viewpoint to control point k, which
// it sees at q: `blocked` lanes, squared length `length2` and bend `bend` of the detour.
#define FOR_EACH_DETOUR(shape, statement)                                                         \
  FOR_EACH_CUT(shape,                                                                             \
               const shape##_point_t from = shape##_cached(&view->shape, i);                      \
               const shape##_point_t to = shape##_control_point(cut, k, q);                       \
               const integer blocked = shape##_blocks(cut, from, to) ^                            \
                                       is_exchanged(view->crossed_cuts, cut_index);               \
               if (ANY(blocked)) {                                                                \
                 vec bend;                                                                        \
                 const real length2 = shape##_detour(cut, from, to, &bend);                       \
                 statement                                                                        \
               })

// Whether a cut is between the viewpoint and control point k, which it sees at q.
inline integer is_hidden(const cuts_t *cuts, const view_t *view, int k, vec q) {
  integer hidden = 0;
  int cut_index = 0;
#define HIDE(shape)                                                                               \
  FOR_EACH_CUT(shape, hidden |= shape##_blocks(cut, shape##_cached(&view->shape, i),              \
                                               shape##_control_point(cut, k, q));)
  SHAPES(HIDE)
  return hidden;
}

// Squared length of the segment to which a detour is compared.
#define SEGMENT2(shape) shape##_distance2(from, to)

// Squared distance that gives a control point the weight of Eq. 27 without damping: d2 times the
// product of (detour / distance)^(nu / alpha) over the cuts between. The cuts see it at q.
HOT real damped_distance2(const cuts_t *cuts, const view_t *view, int k, vec q, real d2,
                          integer *hides_any) {
  detours_t detours = {1, 0, 0};
  int cut_index = 0;
#define LENGTHEN(shape)                                                                           \
  FOR_EACH_DETOUR(shape, add_detour(&detours, blocked, length2, SEGMENT2(shape));)
  SHAPES(LENGTHEN)
  if (!ANY(detours.any)) return d2;
  *hides_any |= detours.any;
  real damped = d2 * to_damping(detours.ratio, cuts->params.damping);
  d2 = select(d2, damped, detours.any);
  return select(d2, (real)(2 * UNREACHABLE), detours.unreachable);
}

// Change of log(detour / distance) as v moves, for the leg from the bend to v.
inline vec detour_slope(vec leg, real length2, vec away) {
  real scale = 1 / fast_max(sqrt(dot3(leg, leg)) * sqrt(fast_max(length2, (real)(0))), 1e-30f);
  return vec_sub(away, vec_scale(scale, leg));
}

// d log(d)/dv for the damping d of Eq. 28; in the rest frame d log(d)/dx.
inline vec damping_slope(const cuts_t *cuts, const view_t *view, int k, vec q) {
  vec segment = vec_sub(view->from, q), slope = {0, 0, 0};
  int cut_index = 0;
#define INCLINE(shape)                                                                            \
  FOR_EACH_DETOUR(shape,                                                                          \
                  vec away = vec_scale(1 / fast_max(SEGMENT2(shape), 1e-30f), segment);           \
                  vec change = detour_slope(vec_sub(view->from, bend), length2, away);            \
                  slope = vec_select(slope, vec_add(slope, change), blocked);)
  SHAPES(INCLINE)
  return vec_scale((real)(cuts->params.nu), slope);
}

// The void distance of a point v with origin g, local units; continuous on each side of the cuts. Below
// 0 where the segment between the two crosses a cut, so that v is void; in the rest frame, where v is
// g, behind a cut of `crossed_cuts`.
inline real void_distance_of(const cuts_t *cuts, vec v, vec g, integer crossed_cuts) {
  real void_distance = FLT_MAX;
  int cut_index = 0;
  for (int i = 0; i < cuts->params.plane_count; ++i) {
    real height = plane_height(vload4(0, cuts->planes[i].plane), g);
    void_distance = fast_min(void_distance, cuts->planes[i].side * height);
  }
#define OPEN(shape)                                                                               \
  FOR_EACH_CUT(shape,                                                                             \
               real distance =                                                                    \
                   shape##_void_distance(cut, shape##_point(cut, v), shape##_point(cut, g));      \
               distance = select(distance, -distance, is_exchanged(crossed_cuts, cut_index));     \
               void_distance = fast_min(void_distance, distance);)
  SHAPES(OPEN)
  return void_distance;
}

// Planes of nodes (coarse_map.cl): a displacement, and a void distance.
#define PLANES 4

inline void set_hiding(view_t *view, integer hides_any) { view->hides_any = hides_any; }

inline int regions_compete(const cuts_t *cuts) { return cuts->params.regions_compete; }
inline int is_second_pass(const cuts_t *cuts) { return cuts->params.second_pass; }
