// The taps of interpolation along one axis: points of an array around a continuous index, and their
// weights. The rules are those of vtk_mls/base/interpolation.py.

#if !defined(SAMPLE_TAPS) || !defined(OFFSET)
#error "SAMPLE_TAPS or OFFSET is missing"
#endif

#define TO_OFFSET(i) GLUE(convert_, OF_LANES(OFFSET))(i)
typedef OF_LANES(OFFSET) offset_t;
#define LANE_OFFSET(offset, l) (((OFFSET *)&(offset))[l])

// An axis with `size` points. In memory are `stored` of them, from point `first` on; `step` is the offset
// from one to the next.
typedef struct { int size, first, stored; OFFSET step; } axis_t;

inline integer is_inside(const axis_t *axis, real x) {
  return (x >= -0.5f) & (x <= axis->size - 0.5f);
}

// Limits an index to the grid; NaN becomes the first.
inline real within(const axis_t *axis, real x) {
  return fast_min(fast_max(x, (real)(0)), (real)(axis->size - 1));
}

// The nearest point in memory.
inline integer nearest_to(const axis_t *axis, real x) {
  const integer nearest = TO_INTEGER(within(axis, x) + 0.5f) - axis->first;
  return clamp(nearest, 0, axis->stored - 1);
}

typedef struct { axis_t x, y, z; } axes_t;

inline axes_t axes_of(const array_t *array, int components) {
  const OFFSET line = (OFFSET)array->stored[0] * components, slice = line * array->stored[1];
  return (axes_t){{array->size[0], array->first[0], array->stored[0], components},
                  {array->size[1], array->first[1], array->stored[1], line},
                  {array->size[2], array->first[2], array->stored[2], slice}};
}

// Which indices are inside the grid.
inline integer are_inside(const axes_t *axes, vec at) {
  return is_inside(&axes->x, at.x) & is_inside(&axes->y, at.y) & is_inside(&axes->z, at.z);
}

inline offset_t offset_of(const axes_t *axes, integer i, integer j, integer k) {
  return TO_OFFSET(k) * axes->z.step + TO_OFFSET(j) * axes->y.step + TO_OFFSET(i) * axes->x.step;
}

// Where the nearest points are in memory.
inline offset_t nearest_offset(const axes_t *axes, vec at) {
  return offset_of(axes, nearest_to(&axes->x, at.x), nearest_to(&axes->y, at.y),
                   nearest_to(&axes->z, at.z));
}

#if SAMPLE_TAPS > 1
// `first` is the first tap, counted from the first point in memory; the point is `behind` the
// grid point before it. Weights are of the type of the sums.
typedef struct { integer first; real behind; sum_t weight[SAMPLE_TAPS]; } taps_t;

// Which lanes have a weight.
#define HAS_WEIGHT(weight) TO_INTEGER((weight) != 0)

// Two taps for linear, four for Catmull-Rom.
HOT void weigh(taps_t *taps) {
  const sum_t t = TO_SUM(taps->behind);
#if SAMPLE_TAPS == 2
  taps->weight[0] = 1 - t;
  taps->weight[1] = t;
#else
  taps->weight[0] = 0.5f * t * fma(t, 2 - t, (sum_t)(-1));
  taps->weight[1] = 0.5f * fma(t * t, fma((sum_t)(3), t, (sum_t)(-5)), (sum_t)(2));
  taps->weight[2] = 0.5f * t * fma(t, fma((sum_t)(-3), t, (sum_t)(4)), (sum_t)(1));
  taps->weight[3] = 0.5f * t * t * (t - 1);
#endif
}

// Finds the taps around x; returns whether all are in memory and have a weight, unlike at a border and
// on a grid point.
HOT integer find_taps(taps_t *taps, const axis_t *axis, real x) {
  x = within(axis, x);
  const integer before = TO_INTEGER(x);
  taps->behind = x - TO_REAL(before);
  taps->first = before - (axis->first + (SAMPLE_TAPS - 1) / 2);
  weigh(taps);
  integer whole = (taps->first >= 0) & (taps->first <= axis->stored - SAMPLE_TAPS);
  UNROLL_ALL for (int tap = 0; tap < SAMPLE_TAPS; ++tap) whole &= HAS_WEIGHT(taps->weight[tap]);
  return whole;
}

// Where taps are in memory. A tap without weight is replaced by the nearest point, so that it adds no
// NaN or infinity.
inline void tap_offsets(offset_t at[SAMPLE_TAPS], const taps_t *taps, const axis_t *axis, integer nearest) {
  for (int tap = 0; tap < SAMPLE_TAPS; ++tap) {
    const integer point = clamp(taps->first + tap, 0, axis->stored - 1);
    at[tap] = TO_OFFSET(select(nearest, point, HAS_WEIGHT(taps->weight[tap]))) * axis->step;
  }
}

// A box of taps around each point, and how far apart in memory they are.
typedef struct { taps_t x, y, z; OFFSET step_x, step_y, step_z; } box_t;

// Where the taps of a box are: from `corner` on, if it is whole, else at x + y + z; and the nearest
// point of the grid.
typedef struct { offset_t corner, nearest, x[SAMPLE_TAPS], y[SAMPLE_TAPS], z[SAMPLE_TAPS]; } offsets_t;

// The offsets of the taps of boxes that are not whole.
inline offsets_t offsets_in(const box_t *box, const axes_t *axes, vec at) {
  offsets_t taps;
  taps.nearest = nearest_offset(axes, at);
  tap_offsets(taps.x, &box->x, &axes->x, nearest_to(&axes->x, at.x));
  tap_offsets(taps.y, &box->y, &axes->y, nearest_to(&axes->y, at.y));
  tap_offsets(taps.z, &box->z, &axes->z, nearest_to(&axes->z, at.z));
  return taps;
}

// Finds the box of taps around each point; returns which are whole.
HOT integer find_box(box_t *box, const axes_t *axes, vec at) {
  box->step_x = axes->x.step, box->step_y = axes->y.step, box->step_z = axes->z.step;
  return find_taps(&box->x, &axes->x, at.x) & find_taps(&box->y, &axes->y, at.y) &
         find_taps(&box->z, &axes->z, at.z);
}
#endif
