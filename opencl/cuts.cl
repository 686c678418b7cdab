// Cuts (section 4): the damping of Eq. 28, and the void. Rules of the shapes: vtk_mls/cuts.
//
// Full planes do not appear here as obstacles: the host gives each of their sides its own control
// points, and a launch computes the points of one side (`in_region`).

#define REST_FRAME (AT_REST || RIVALS)

// SHAPES(X) is X(shape) for each shape of cuts that one can go round; each has a table.
#define SHAPE_TABLE(shape) __global const float *shape;
typedef struct {
  cut_numbers_t numbers;
  __global const plane_t *planes;
  SHAPES(SHAPE_TABLE)
} cuts_t;

#define SHAPE_PARAMETER(shape) , __global const float *restrict shape##_table
#define SHAPE_ARGUMENT(shape) , shape##_table
#define CUT_PARAMETERS             \
  , const cut_numbers_t cut_numbers, \
      __global const plane_t *restrict planes SHAPES(SHAPE_PARAMETER)
#define CUTS_OF_LAUNCH \
  , { cut_numbers, planes SHAPES(SHAPE_ARGUMENT) }

// A table of cuts: their number, where the record of each begins, the records.
inline int count_of(__global const float *table) { return as_int(table[0]); }
inline __global const float *record_of(__global const float *table, int i) {
  return table + as_int(table[1 + i]);
}

inline vec load3(__global const float *from) { return (vec){from[0], from[1], from[2]}; }

inline real distance3(vec a, vec b) {
  vec d = vec_sub(a, b);
  return sqrt(dot3(d, d));
}

inline real clamp01(real x) { return least(most(x, (real)(0)), (real)(1)); }

// The functions of a shape that takes points as they are, and keeps nothing of them.
#define PLAIN_POINTS(shape)                                                                       \
  typedef vec shape##_point_t;                                                                    \
  typedef vec shape##_view_t;                                                                     \
  inline int shape##_count(__global const float *table) { return count_of(table); }               \
  inline vec shape##_point(__global const float *cut, vec x) { return x; }                        \
  inline vec shape##_view(__global const float *table, vec v) { return v; }                       \
  inline vec shape##_seen(const vec *view, int i) { return *view; }                               \
  inline vec shape##_control_point(__global const float *cut, int k, vec q) { return q; }         \
  inline real shape##_distance2(vec a, vec b) { return dot3(vec_sub(a, b), vec_sub(a, b)); }

#define NO_DETOUR -1.0f

// Squared distance of what a closed surface keeps apart, at least.
#define UNREACHABLE 1e29f

#include SHAPE_FILES

inline real plane_height(const float4 plane, vec x) {
  return fma(plane.x, x.x, fma(plane.y, x.y, fma(plane.z, x.z, (real)(plane.w))));
}

// Whether the point of a grid with this index is on this launch's side of all planes. Indices are the
// same numbers in every launch, so each point belongs to just one.
inline integer in_region(const cuts_t *cuts, vec index) {
  integer inside = (real)(0) == 0;
  for (int i = 0; i < cuts->numbers.plane_count; ++i) {
    integer below = plane_height(vload4(0, cuts->planes[i].index_plane), index) < 0;
    inside &= cuts->planes[i].side < 0 ? below : !below;
  }
  return inside;
}

// Whether x, local, is on this launch's side of all planes, for what rounding is relative to.
inline integer on_side(const cuts_t *cuts, vec x, real size) {
  integer inside = (real)(0) == 0;
  for (int i = 0; i < cuts->numbers.plane_count; ++i) {
    real height = plane_height(vload4(0, cuts->planes[i].plane), x);
    inside &= cuts->planes[i].side * height >= -ON_PLANE * size;
  }
  return inside;
}

inline vec mean_displacement_of(const cuts_t *cuts) {
  const float *mean_displacement = cuts->numbers.mean_displacement;
  return (vec){mean_displacement[0], mean_displacement[1], mean_displacement[2]};
}

// Local point where the material at v came from, for its displacement less the mean displacement.
inline vec origin_of(const cuts_t *cuts, vec v, vec d) {
  return vec_add(vec_add(v, d), mean_displacement_of(cuts));
}

// Whether a cut that one can go round is between v and g.
inline integer blocked(const cuts_t *cuts, vec v, vec g) {
  integer anything = 0;
#define BLOCK(shape)                                                                              \
  for (int i = 0; i < shape##_count(cuts->shape); ++i) {                                          \
    __global const float *cut = record_of(cuts->shape, i);                                        \
    anything |= shape##_blocks(cut, shape##_point(cut, v), shape##_point(cut, g));                \
  }
  SHAPES(BLOCK)
  return anything;
}

// The cuts between v and g that one can go round: bit i for cut i.
inline integer crossed(const cuts_t *cuts, vec v, vec g) {
  integer found = 0;
  int number = 0;
#define CROSS(shape)                                                                              \
  for (int i = 0; i < shape##_count(cuts->shape); ++i, ++number) {                                \
    __global const float *cut = record_of(cuts->shape, i);                                        \
    integer between = shape##_blocks(cut, shape##_point(cut, v), shape##_point(cut, g));          \
    found |= select((integer)(0), (integer)(1 << number), between);                               \
  }
  SHAPES(CROSS)
  return found;
}

// Distances that are kept between the two passes over the control points; registers of a GPU are few.
#if LANES > 1
#define KNOWN 64
#else
#define KNOWN 0
#endif

// A point with what the cuts need to know of it.
#define SHAPE_VIEW(shape) shape##_view_t shape;
typedef struct {
  vec v;
#if KNOWN
  real known[KNOWN];  // damped squared distances of the first control points
#endif
#if AT_REST
  vec seen;           // the material's place in the undeformed space, from where cuts are seen
  integer passed;     // bit i is set where the material is seen from behind cut i (rest_frame.cl)
  integer hides;      // whether a cut turned out to hide any of the control points
#endif
  SHAPES(SHAPE_VIEW)
} view_t;

// Makes the view of a point v from which cuts are seen as from `seen`.
inline void look(const cuts_t *cuts, view_t *view, vec v, vec seen) {
  view->v = v;
#if AT_REST
  view->seen = seen;
  view->passed = view->hides = (integer)(0);
#endif
#define LOOK(shape) view->shape = shape##_view(cuts->shape, seen);
  SHAPES(LOOK)
}

#if AT_REST
#define SEEN(view) (view)->seen
#define PASSED(view) (view)->passed
#define HAS_PASSED(passed, i) (((passed) & (1 << (i))) != 0)
#else
#define SEEN(view) (view)->v
#define PASSED(view) (integer)(0)
#define HAS_PASSED(passed, i) (integer)(0)
#endif

// ratio^damping; the common powers, nu / alpha = 2, 3 and 4, without logarithms.
inline real to_damping(real ratio, float damping) {
  if (damping == 1) return ratio;
  if (damping == 1.5f) return ratio * sqrt(ratio);
  if (damping == 2) return ratio * ratio;
  return fast_exp2(damping * fast_log2(ratio));
}

// What the cuts between v and a control point make of the squared distance.
typedef struct {
  real ratio;  // product of (detour / distance)^2
  integer anything, unreachable;
} detours_t;

inline void add_detour(detours_t *detours, integer blocked, real length2, real d2) {
  real longer = most(length2 / most(d2, 1e-30f), (real)(1));
  detours->ratio = select(detours->ratio, detours->ratio * longer, blocked);
  detours->anything |= blocked;
  detours->unreachable |= blocked & (length2 < 0);
}

// Runs `statement` for each cut between SEEN(view) and control point k, there seen at q, with `blocked`
// and the squared `length2` of the detour, which bends at `bend`. `number` counts the cuts.
#define EACH_DETOUR(shape, statement)                                                             \
  for (int i = 0; i < shape##_count(cuts->shape); ++i, ++number) {                                \
    __global const float *cut = record_of(cuts->shape, i);                                        \
    shape##_point_t from = shape##_seen(&view->shape, i),                                         \
                    to = shape##_control_point(cut, k, q);                                        \
    integer blocked = shape##_blocks(cut, from, to) ^ HAS_PASSED(PASSED(view), number);           \
    if (ANY(blocked)) {                                                                           \
      vec bend;                                                                                   \
      real length2 = shape##_detour(cut, from, to, &bend);                                        \
      statement                                                                                   \
    }                                                                                             \
  }

// Whether a cut is between SEEN(view) and control point k, there seen at q.
inline integer is_hidden(const cuts_t *cuts, const view_t *view, int k, vec q) {
  integer hidden = 0;
#define HIDE(shape)                                                                               \
  for (int i = 0; i < shape##_count(cuts->shape); ++i) {                                          \
    __global const float *cut = record_of(cuts->shape, i);                                        \
    shape##_point_t from = shape##_seen(&view->shape, i);                                         \
    hidden |= shape##_blocks(cut, from, shape##_control_point(cut, k, q));                        \
  }
  SHAPES(HIDE)
  return hidden;
}

// Squared length of the segment that a detour is compared to.
#if AT_REST
#define SEGMENT2(shape) shape##_distance2(from, to)
#else
#define SEGMENT2(shape) d2
#endif

// Squared distance that gives a control point the weight of Eq. 27 without damping: d2 times the
// product of (detour / distance)^(nu / alpha) over the cuts between. The cuts see it at q.
HOT real damped_distance2(const cuts_t *cuts, const view_t *view, int k, vec q, real d2,
                             integer *hides) {
  detours_t detours = {1, 0, 0};
  int number = 0;
#define LENGTHEN(shape)                                                                           \
  EACH_DETOUR(shape, add_detour(&detours, blocked, length2, SEGMENT2(shape));)
  SHAPES(LENGTHEN)
  if (!ANY(detours.anything)) return d2;
  *hides |= detours.anything;
  real damped = d2 * to_damping(detours.ratio, cuts->numbers.damping);
  d2 = select(d2, damped, detours.anything);
  return select(d2, (real)(2 * UNREACHABLE), detours.unreachable);
}

// Change of log(detour / distance) as v moves, for the leg from the bend to v.
inline vec detour_slope(vec leg, real length2, vec away) {
  real scale = 1 / most(sqrt(dot3(leg, leg)) * sqrt(most(length2, (real)(0))), 1e-30f);
  return vec_sub(away, vec_scale(scale, leg));
}

// d log(d)/dv for the damping d of Eq. 28, or as SEEN(view) moves.
inline vec damping_slope(const cuts_t *cuts, const view_t *view, int k, vec q, real d2) {
  vec segment = vec_sub(SEEN(view), q), slope = {0, 0, 0};
  int number = 0;
#define INCLINE(shape)                                                                            \
  EACH_DETOUR(shape, vec away = vec_scale(1 / most(SEGMENT2(shape), 1e-30f), segment);           \
              vec change = detour_slope(vec_sub(SEEN(view), bend), length2, away);                \
              slope = vec_select(slope, vec_add(slope, change), blocked);)
  SHAPES(INCLINE)
  return vec_scale((real)(cuts->numbers.nu), slope);
}

// The void distance of a point v with the origin g; continuous on each side of the cuts. Below 0 where
// the segment between the two crosses a cut, so that there is nothing at v, or in the rest frame,
// where v is g, behind a cut that is `passed`. Local units.
inline real void_distance_of(const cuts_t *cuts, vec v, vec g, integer passed) {
  real void_distance = FLT_MAX;
  int number = 0;
  for (int i = 0; i < cuts->numbers.plane_count; ++i) {
    real height = plane_height(vload4(0, cuts->planes[i].plane), g);
    void_distance = least(void_distance, cuts->planes[i].side * height);
  }
#define OPEN(shape)                                                                               \
  for (int i = 0; i < shape##_count(cuts->shape); ++i, ++number) {                                \
    __global const float *cut = record_of(cuts->shape, i);                                        \
    real here = shape##_void_distance(cut, shape##_point(cut, v), shape##_point(cut, g));         \
    here = select(here, -here, HAS_PASSED(passed, number));                                       \
    void_distance = least(void_distance, here);                                                   \
  }
  SHAPES(OPEN)
  return void_distance;
}
