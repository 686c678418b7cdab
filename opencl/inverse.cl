// The inverse of the backward map: for points x the displacement v - x to v with G(v) = x.
//
// All x are less the mean displacement, and local. The map's displacement d(v) = G(v) - v is small
// next to v, so what is searched is the displacement s with s + d(x + s) = 0: no digits are lost in
// v - x.

#include "map.cl"
#include "lattice.cl"

#define TRIALS 32
#define SMALLEST_SHARE 0.03f
#define DECREASE 0.1f            // of what a step promises, at least
#define INVERSE_TOLERANCE 3e-7f  // next to x: about what float32 resolves
#define CHORDS 5
#define CHORD_TOLERANCE 5e-6f    // left for a last step that needs no check

inline real length3(vec a) { return sqrt(dot3(a, a)); }

// x - G(x + displacement), with the fit there. In the rest frame of cuts the material is known, so that
// all of them see from x.
inline vec residual(const map_t *map, vec x, vec displacement, fit_t *fit) {
#if AT_REST
  vec seen = origin_of(&map->cuts, x, (vec){0, 0, 0});
  look(&map->cuts, &fit->view, vec_add(x, displacement), seen);
  fit_view(map, fit);
#else
  *fit = fit_at(map, vec_add(x, displacement));
#endif
  return vec_scale((real)(-1), vec_add(displacement, moved(map, fit)));
}

#if CUTS && !REST_FRAME
// The position of x itself.
inline vec undisplaced(const cuts_t *cuts, vec x) { return origin_of(cuts, x, (vec){0, 0, 0}); }

// Whether the displacement leads through a cut that one can go round: the material is not there.
inline integer is_blocked(const map_t *map, vec x, vec displacement) {
  return blocked(&map->cuts, undisplaced(&map->cuts, x), vec_add(x, displacement));
}

// Whether the displacement leads through any cut.
inline integer is_cut_off(const map_t *map, vec x, vec displacement) {
  return is_blocked(map, x, displacement) |
         !on_side(&map->cuts, vec_add(x, displacement), size_of(x));
}
#else
#define is_blocked(map, x, displacement) ((integer)(0))
#define is_cut_off(map, x, displacement) ((integer)(0))
#endif

// Newton's method from a first guess in `displacement`; what is left next to the size of x. A step
// that comes hardly closer is halved, and the next one is at most twice as long: where there is no
// inverse the search is soon over. It may pass cuts: what counts is where it ends (is_cut_off). A lane
// whose search is over keeps what it has, however long those beside it go on.
inline real newton(const map_t *map, vec x, vec *displacement) {
  real left = FLT_MAX, share = 1, close = INVERSE_TOLERANCE * size_of(x);
  vec step = {0, 0, 0}, trial = *displacement;
  integer open = (real)(0) == 0;
  for (int i = 0; i < TRIALS; ++i) {
    fit_t fit;
    vec r = residual(map, x, trial, &fit);
    real distance = length3(r);
    integer better = open & (distance < left * fma(-DECREASE, share, (real)(1)));
    *displacement = vec_select(*displacement, trial, better);
    left = select(left, distance, better);
    share = select(share * 0.5f, least(2 * share, (real)(1)), better);
    open &= (left > close) & (share > SMALLEST_SHARE);
    if (!ANY(open)) break;
    if (ANY(open & better)) {
      mat jacobian = material_jacobian(map, &fit);
      step = vec_select(step, identity_solve(&jacobian, r), better);
    }
    trial = vec_madd(share, step, *displacement);
  }
  return left / size_of(x);
}

// Broyden's method from a first guess in `displacement` and one for dv/dx in `response`: no
// Jacobians, no step control. What is left next to the size of x, before a last step.
inline real broyden(const map_t *map, vec x, vec *displacement, mat *response) {
  real left = FLT_MAX, close = CHORD_TOLERANCE * size_of(x);
  vec step = {0, 0, 0};
  for (int i = 0; i < CHORDS; ++i) {
    fit_t fit;
    integer open = left > close;
    vec r = residual(map, x, *displacement, &fit);
    left = select(left, length3(r), open);
    // the response to the last step was not `step`, as foreseen, but step - t
    vec t = mat_vec(response, r);
    real square = dot3(step, step), change = dot3(step, t);
    real gain = 1 / most(square - change, fma((real)(0.2f), square, (real)(1e-30f)));
    add_outer(response, vec_scale(gain, t), transposed_mat_vec(response, step));
    step = vec_scale(fma(change, gain, (real)(1)), t);
    *displacement = vec_select(*displacement, vec_add(*displacement, step), open);
    if (!ANY(left > close)) break;
  }
  return left / size_of(x);
}

// Whether a cut parts x from a sample of the map, in the frame of the cuts.
inline integer is_parted(const map_t *map, vec x, vec image, vec displacement) {
#if AT_REST
  const vec none = {0, 0, 0};
  return blocked(&map->cuts, origin_of(&map->cuts, x, none), origin_of(&map->cuts, image, none));
#else
  return is_blocked(map, x, displacement);
#endif
}

// The displacement to the sample that the map brings nearest to x, but farther than `*tried`
// (squared), which becomes its distance.
inline vec displacement_to_nearest(const map_t *map, vec x, int count,
                                   __global const sample_t *samples, real *tried) {
  real nearest = FLT_MAX;
  vec displacement = {0, 0, 0};
  for (int i = 0; i < count; ++i) {
    __global const sample_t *at = samples + i;
    vec miss = vec_sub(x, (vec){at->image[0], at->image[1], at->image[2]});
    real d2 = dot3(miss, miss);
    integer nearer = (d2 < nearest) & (d2 > *tried);
    if (!ANY(nearer)) continue;
    vec there = vec_sub((vec){at->v[0], at->v[1], at->v[2]}, x);
    nearer &= !is_parted(map, x, vec_sub(x, miss), there);
    displacement = vec_select(displacement, there, nearer);
    nearest = select(nearest, d2, nearer);
  }
  *tried = nearest;
  return displacement;
}

// The displacement at x, trilinear in displacements at the `nodes` of the lattice, and dv/dx; whether
// x is in a cell. Nodes are counted as cells are.
inline integer guess_at(const lattice_t *lattice, __global const float4 *nodes, vec x,
                        vec *displacement, mat *response) {
  vec share;
  real shrink;
  integer node_number, inside = lattice_cell(lattice, x, &share, &shrink, &node_number) < LATTICE_SIZE;
  for (int l = 0; l < LANES; ++l) {
    __global const float4 *node = nodes + (LANE_INT(inside, l) ? LANE_INT(node_number, l) : 0);
    float u = LANE(share.x, l), v = LANE(share.y, l), w = LANE(share.z, l);
    float density = 0.5f * LATTICE_CELLS * LANE(shrink, l);
    float4 n00 = node[0], n10 = node[NODES_ALONG], d00 = node[1] - n00,
           d10 = node[NODES_ALONG + 1] - n10;
    node += NODES_ALONG * NODES_ALONG;
    float4 n01 = node[0], n11 = node[NODES_ALONG], d01 = node[1] - n01,
           d11 = node[NODES_ALONG + 1] - n11;
    n00 += u * d00, n10 += u * d10, n01 += u * d01, n11 += u * d11;
    float4 d0 = d00 + v * (d10 - d00), d1 = d01 + v * (d11 - d01);
    float4 e0 = n10 - n00, e1 = n11 - n01, n0 = n00 + v * e0, n1 = n01 + v * e1;
    float4 dx = density * lattice->density[0] * (d0 + w * (d1 - d0)),
           dy = density * lattice->density[1] * (e0 + w * (e1 - e0)),
           dz = density * lattice->density[2] * (n1 - n0), n = n0 + w * (n1 - n0);
    LANE(displacement->x, l) = n.x;
    LANE(displacement->y, l) = n.y;
    LANE(displacement->z, l) = n.z;
    LANE(response->a[0], l) = 1 + dx.x;
    LANE(response->a[1], l) = dy.x;
    LANE(response->a[2], l) = dz.x;
    LANE(response->a[3], l) = dx.y;
    LANE(response->a[4], l) = 1 + dy.y;
    LANE(response->a[5], l) = dz.y;
    LANE(response->a[6], l) = dx.z;
    LANE(response->a[7], l) = dy.z;
    LANE(response->a[8], l) = 1 + dz.z;
  }
  return inside;
}
