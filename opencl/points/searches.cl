// Searches for the origins of many points. A lane whose search ends continues with the next point, so
// that no lane waits for the slowest. Only with cuts in the rest frame.

// Loads point i into a lane.
inline void load_lane(vec *x, int l, __global const float *planes, long count, long i) {
  LANE(x->x, l) = planes[i];
  LANE(x->y, l) = planes[i + count];
  LANE(x->z, l) = planes[i + 2 * count];
}

// Stores three planes of displacements and one of void distances for points `first` + `at`.
inline void scatter(__global float *planes, vec d, real void_distance, long count, long first,
                    integer at, integer ended) {
  for (int l = 0; l < LANES; ++l) {
    if (!LANE_INT(ended, l)) continue;
    __global float *to = planes + first + LANE_INT(at, l);
    to[0] = LANE(d.x, l);
    to[count] = LANE(d.y, l);
    to[2 * count] = LANE(d.z, l);
    to[3 * count] = LANE(void_distance, l);
  }
}

// Vectors of points of a work item. GPUs have one lane, and need many work items.
#define VECTORS (LANES > 1 ? 16 : 1)

// Searches start at `starts` and stay on their side of the cuts; if null, at the affine map. Every
// VECTORS-th work item does the work of VECTORS items.
inline void search_points(const map_t *map, long count, __global const float *points,
                          __global const float *starts, __global float *displacement) {
  const long first = (long)get_global_id(0) * LANES;
  if (get_global_id(0) % VECTORS != 0 || first >= count) return;
  const int stop = (int)min(count - first, (long)(VECTORS * LANES));
  searches_t searches = {{0}};
  fit_t fit;
  integer at = 0, ended = (real)(0) == 0, active = ended;
  vec v = {0, 0, 0};
  start_t start = {v, UNKNOWN_SLOPE};
  for (int next = 0;;) {
    for (int l = 0; l < LANES; ++l) {
      if (!LANE_INT(ended, l)) continue;
      LANE_INT(active, l) = next < stop ? -1 : 0;
      LANE_INT(at, l) = min(next++, stop - 1);
      load_lane(&v, l, points, count, first + LANE_INT(at, l));
      if (starts) load_lane(&start.x, l, starts, count, first + LANE_INT(at, l));
    }
    if (!ANY(active)) return;
    if (!starts) start = affine_start(map, v);
    search_from(&searches, v, start, starts != 0, ended & active);
    ended = evaluate_searches(map, &searches, &fit, active) & active;
    if (!ANY(ended)) continue;
    vec d = map_displacement(map, &fit);
    scatter(displacement, d, void_distance_at(map, &fit, d), count, first, at, ended);
  }
}
