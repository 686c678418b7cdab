// First guesses for searches over a grid: the origin x and its changes at nodes, every NODE_STEP-th
// point of the whole grid along each axis. Most searches end at their start. A guess depends on the
// index of its point only: parts are computed like the whole.
//
// Linear interpolation of the corners' predictions with half of their slopes is exact for quadratic
// functions. A term along each axis makes it exact for cubic ones.

// Where a point is in the faces of its cell that are across i: (b, c) from 0 to 1. `share` has the weights
// of linear interpolation between the corners of a face, `weights` those of the members of their nodes.
typedef struct {
  float b, c;
  float4 share[4];
  float16 weights[4];
} place_t;

// What interpolation between 0 and 1 with half of the slopes leaves of x^3.
#define CUBIC_PART(x) ((x) * ((x) - 0.5f) * ((x) - 1))

inline place_t place_of(float b, float c) {
  const float4 at_j = (float4)(0, 1, 0, 1), at_k = (float4)(0, 0, 1, 1);
  const float4 along_b = fabs(1 - at_j - b), along_c = fabs(1 - at_k - c), share = along_b * along_c;
  const float4 bent_b = along_c * CUBIC_PART(b), bent_c = along_b * CUBIC_PART(c);
  const float4 x = share + 2 * ((1 - 2 * at_j) * bent_b + (1 - 2 * at_k) * bent_c);
  const float4 by_j = fma(0.5f * share, b - at_j, bent_b), by_k = fma(0.5f * share, c - at_k, bent_c);
  place_t place = {b, c};
#define SET_CORNER(n, s) \
  place.share[n] = share.s; \
  place.weights[n] = (float16)(x.s, share.s, by_j.s, by_k.s);
  SET_CORNER(0, s0000)
  SET_CORNER(1, s1111)
  SET_CORNER(2, s2222)
  SET_CORNER(3, s3333)
  return place;
}

// At a place in a face: x, its change along i, and x by linear interpolation.
typedef struct { float4 x, by_i, linear; } face_t;

inline face_t face_at(const nodes_t *nodes, __global const node_t *corner, const place_t *place) {
  float16 sum = 0;
  float4 linear = 0;
  for (int n = 0; n < 4; ++n) {
    __global const node_t *node = corner + n % 2 * nodes->nx + n / 2 * nodes->nx * nodes->ny;
    const float16 members = vload16(0, (__global const float *)node);
    sum += place->weights[n] * members;  // fma() of 512 bits does not build with PoCL before version 5
    linear = fma(place->share[n], members.s0123, linear);
  }
  return (face_t){sum.s0123 + sum.s89ab + sum.scdef, sum.s4567, linear};
}

// The cell of a point, and the relative position in it.
inline integer cell_of(const nodes_t *nodes, vec index, vec *share) {
  const int *first = nodes->first;
  vec at = vec_scale((real)(1.0f / NODE_STEP), index);
  vec cell = {floor(at.x), floor(at.y), floor(at.z)};
  *share = vec_sub(at, cell);
  integer j = TO_INTEGER(cell.y) - first[1] + nodes->ny * (TO_INTEGER(cell.z) - first[2]);
  return TO_INTEGER(cell.x) - first[0] + nodes->nx * j;
}

// The start of searches for the whole-grid points `index`. Neighboring points mostly share cells.
inline start_t start_at(const map_t *map, const nodes_t *nodes, __global const node_t *table,
                        vec index, vec v) {
  const start_t expected = affine_start(map, v);
  start_t start = expected;
  vec share;
  const integer cell = cell_of(nodes, index, &share);
  const real a = share.x;
  place_t place;
  face_t low, high;
  int last = -1;  // the cell before
  for (int l = 0; l < LANES; ++l) {
    const int here = LANE_INT(cell, l);
    const float b = LANE(share.y, l), c = LANE(share.z, l);
    if (here == last && place.b == b && place.c == c) continue;
    __global const node_t *corner = table + here;
    const float slope = corner->by_i.w;
    const integer same = (cell == here) & (share.y == b) & (share.z == c);
    if (last < 0 || place.b != b || place.c != c) {
      place = place_of(b, c);
      last = -1;
    }
    low = last >= 0 && last + 1 == here ? high : face_at(nodes, corner, &place);
    high = face_at(nodes, corner + 1, &place);
    last = here;
    const float4 change = high.x - low.x, bend = 0.5f * (low.by_i - high.by_i),
                 cubic = 2 * (high.linear - low.linear) - low.by_i - high.by_i;
    const real square = a - a * a, odd = a - 0.5f;
#define START(s) \
  fma(square, fma(odd, (real)(cubic.s), (real)(bend.s)), fma(a, (real)(change.s), (real)(low.x.s)))
    if (!(slope >= 0)) continue;
    start.x = vec_select(start.x, (vec){START(x), START(y), START(z)}, same);
    start.slope = select(start.slope, (real)(slope), same);
  }
  // the affine start where a cut is between the two
  const integer is_separated = blocked(&map->cuts, start.x, expected.x);
  start.x = vec_select(start.x, expected.x, is_separated);
  start.slope = select(start.slope, expected.slope, is_separated);
  return start;
}

// The fit at a point of a grid.
inline fit_t fit_from_nodes(const map_t *map, const nodes_t *nodes, __global const node_t *table,
                            vec index, vec v) {
  return solve_origin(map, v, start_at(map, nodes, table, index, v));
}
