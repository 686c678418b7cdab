"""Each small function of the kernels alone, against float64, with the bound of its comment."""

import itertools
from functools import partial

import numpy as np
import pytest
from control_point_sets import DEVICES, random_rotation
from kernel_functions import call

from vtk_mls import Deformation, HalfPlane, Surface
from vtk_mls.engine.device import devices as device
from vtk_mls.engine.map.cut_tables import cut_tables
from vtk_mls.model.kinds.polynomials import Polynomial, monomial_gradients, monomial_values

ROTATION = ["rotation.cl"]
AXES = "(vec){a[0], a[1], a[2]}"
COUNT = 2000


@pytest.fixture(params=list(itertools.product(DEVICES, ["vectors", "scalars"])), ids=str)
def of(request):
    """`call` on a device, a point or a vector of them at a time."""
    key, lanes = request.param
    chosen = next(found for found in device.list_devices() if found.key == key)
    return partial(call, key, chosen.lanes if lanes == "vectors" else 1)


def quaternion(text, rows):
    """OpenCL C that makes a quaternion of elements of `a`."""
    return f"quaternion_t {text} = {{{', '.join(f'a[{i}]' for i in rows)}}};"


def matrix(name, first=0):
    elements = ", ".join(f"a[{i}]" for i in range(first, first + 9))
    return f"mat {name} = {{{{{elements}}}}};"


def results(text, names):
    return " ".join(f"r[{i}] = {text}.{name};" for i, name in enumerate(names))


def rotation_of(q):
    """Matrices (n, 3, 3) of unit quaternions (n, 4)."""
    w, x, y, z = q.T.astype(float)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def units(rng, shape):
    x = rng.normal(size=shape)
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def test_exp2(of, rng):
    x = np.float32(np.r_[rng.uniform(-126, 126, COUNT), -126, 126, 0, -0.5, 0.5, 0.49999997])
    got = of(["powers.cl"], "r[0] = fast_exp2(a[0]);", x[:, None], 1, TWICE_ALPHA=0)[:, 0]
    truth = np.exp2(x.astype(float))
    assert (np.abs(got - truth) <= 2.2e-7 * truth).all()


def test_exp2_is_clamped(of):
    got = of(["powers.cl"], "r[0] = fast_exp2(a[0]);", [[-140], [-1e30]], 1, TWICE_ALPHA=0)
    assert (got <= 2.0**-125).all()
    assert (got >= 0).all()


def test_log2(of, rng):
    x = np.float32(np.r_[np.exp2(rng.uniform(-126, 127, COUNT)), 1, 2, 0.5, np.sqrt([2, 0.5])])
    x = np.r_[x, np.float32(rng.uniform(0.5, 2, COUNT))]
    got = of(["powers.cl"], "r[0] = fast_log2(a[0]);", x[:, None], 1, TWICE_ALPHA=0)[:, 0]
    truth = np.log2(x.astype(float))
    assert (np.abs(got - truth) <= 1e-7 + 6e-8 * np.abs(truth)).all()


@pytest.mark.parametrize("alpha", [0.5, 1, 1.5, 2, 3, 0.7, 2.3])
def test_powers(of, alpha, rng):
    x = np.float32(np.r_[rng.uniform(0, 1, COUNT), 10 ** rng.uniform(-12, 0, COUNT), 0, 1])
    twice = int(2 * alpha) if 2 * alpha in (1, 2, 3, 4, 6) else 0
    body = f"r[0] = power(a[0], {float(alpha)}f);"
    got = of(["powers.cl"], body, x[:, None], 1, TWICE_ALPHA=twice)[:, 0]
    truth = x.astype(float) ** np.float32(alpha)
    # a logarithm of up to 40 has digits to 2e-6, and alpha as many of them
    bound = 3e-7 if twice else 1e-6 + 1e-7 * alpha * -np.log2(np.maximum(x, 1e-30))
    is_normal = truth > 1e-36
    assert (np.abs(got - truth)[is_normal] <= (bound * truth)[is_normal]).all()
    assert got[-2] == 0
    assert abs(got[-1] - 1) <= (0 if twice else 2e-7)


def test_reciprocal_square_roots(of, rng):
    x = np.float32(10 ** rng.uniform(-37, 38, COUNT))
    got = of([], "r[0] = fast_rsqrt(a[0]);", x[:, None], 1)[:, 0]
    truth = 1 / np.sqrt(x.astype(float))
    assert (np.abs(got - truth) <= 2e-7 * truth).all()


def test_unit_vectors(of, rng):
    x = np.float32(units(rng, (COUNT, 3)) * 10 ** rng.uniform(-12, 12, (COUNT, 1)))
    x[-1] = 0
    got = of([], f"vec u = unit3({AXES}); {results('u', 'xyz')}", x, 3)
    truth = x[:-1].astype(float) / np.linalg.norm(x[:-1].astype(float), axis=1, keepdims=True)
    np.testing.assert_allclose(got[:-1], truth, atol=5e-7)
    assert (got[-1] == 0).all()


def test_products_of_vectors_and_matrices(of, rng):
    x = rng.normal(size=(COUNT, 15)).astype(np.float32)
    body = f"""vec x = {AXES}, y = {{a[3], a[4], a[5]}}; {matrix("m", 6)}
    r[0] = dot3(x, y); vec c = cross3(x, y); r[1] = c.x; r[2] = c.y; r[3] = c.z;
    vec d = mat_vec(&m, x), e = transposed_mat_vec(&m, x);
    r[4] = d.x; r[5] = d.y; r[6] = d.z; r[7] = e.x; r[8] = e.y; r[9] = e.z;
    add_outer(&m, x, y); for (int i = 0; i < 9; ++i) r[10 + i] = m.a[i];"""
    got = of([], body, x, 19)
    x = x.astype(float)
    a, b, m = x[:, :3], x[:, 3:6], x[:, 6:].reshape(-1, 3, 3)
    truth = [np.sum(a * b, axis=1)[:, None], np.cross(a, b)]
    truth += [np.einsum("nij,nj->ni", m, a), np.einsum("nij,ni->nj", m, a)]
    truth += [(m + a[:, :, None] * b[:, None]).reshape(-1, 9)]
    np.testing.assert_allclose(got, np.hstack(truth), atol=4e-6)


def test_quaternions_are_rotations(of, rng):
    q = np.hstack([units(rng, (COUNT, 4)), units(rng, (COUNT, 4))])
    body = f"""{quaternion("p", range(4))} {quaternion("q", range(4, 8))}
    mat m = rotation_change(p); for (int i = 0; i < 9; ++i) r[i] = m.a[i];
    quaternion_t s = product(p, q); r[9] = s.w; r[10] = s.x; r[11] = s.y; r[12] = s.z;"""
    got = of(ROTATION, body, q, 13)
    q = np.float32(q)
    turn = rotation_of(q[:, :4])
    np.testing.assert_allclose(got[:, :9].reshape(-1, 3, 3) + np.eye(3), turn, atol=1e-6)
    both = rotation_of(got[:, 9:])
    np.testing.assert_allclose(both, turn @ rotation_of(q[:, 4:]), atol=2e-6)


def test_a_small_turn_has_all_its_digits(of, rng):
    """R - I is computed as such, not as a difference."""
    angle = 10 ** rng.uniform(-12, -3, COUNT)
    axis = units(rng, (COUNT, 3))
    q = np.column_stack([np.cos(angle / 2), np.sin(angle / 2)[:, None] * axis])
    body = f"{quaternion('q', range(4))} mat m = rotation_change(q); r[0] = m.a[1]; r[1] = m.a[2];"
    got = of(ROTATION, body, q, 2)
    truth = np.column_stack([-axis[:, 2], axis[:, 1]]) * angle[:, None]
    assert (np.abs(got - truth).max(axis=1) <= 1e-6 * angle + angle**2).all()


def test_inverses_of_symmetric_matrices(of, rng):
    m = rng.normal(size=(COUNT, 3, 3))
    m = m @ np.swapaxes(m, 1, 2) + 0.3 * np.eye(3)
    packed = m[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].astype(np.float32)
    packed[-1] = [1, 1, 0, 1, 0, 0]  # singular
    body = """real k[6], i[6]; for (int j = 0; j < 6; ++j) k[j] = a[j];
    invert_symmetric(k, i); for (int j = 0; j < 6; ++j) r[j] = i[j];"""
    got = of(ROTATION, body, packed, 6)
    full = got[:-1, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3).astype(float)
    p = packed[:-1, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3).astype(float)
    condition = np.linalg.cond(p)
    error = np.linalg.norm(full @ p - np.eye(3), axis=(1, 2))
    assert (error <= 2e-6 * condition).all()
    assert (got[-1] == 0).all()


def covariances(rng, ratios, scale=1.0):
    """Matrices U diag(ratios) V^T (n, 3, 3), and the rotations that fit them best."""
    u, v = (np.stack([random_rotation(rng) for _ in range(COUNT // 4)]) for _ in range(2))
    return scale * np.einsum("nij,j,nkj->nik", u, ratios, v), u @ np.swapaxes(v, 1, 2)


@pytest.mark.parametrize(
    ("ratios", "bound"),
    [
        ((1, 0.7, 0.4), 1e-6),
        ((1, 1, 1), 1e-6),
        ((1, 0.5, 0), 1e-6),  # control points in a plane
        ((1, 0.1, 0.001), 2e-6),
        ((1, 0.01, 0.0001), 2e-5),  # nearly on a line: the twist has two digits less
        ((1, 0.7, -0.3), 2e-6),  # a reflection fits better, but is no rotation
    ],
)
@pytest.mark.parametrize("scale", [1e-12, 1, 1e12])
def test_the_rotation_that_fits_best(of, ratios, bound, scale, rng):
    c, truth = covariances(rng, ratios, scale)
    body = f"{matrix('c')} real slope; quaternion_t q = whole_rotation(&c, &slope);"
    got = of(ROTATION, f"{body} {results('q', 'wxyz')}", c.reshape(-1, 9), 4)
    np.testing.assert_allclose(rotation_of(got), truth, atol=bound)


def test_no_covariance_is_no_rotation(of):
    body = f"{matrix('c')} real slope; quaternion_t q = whole_rotation(&c, &slope);"
    got = of(ROTATION, f"{body} {results('q', 'wxyz')}", np.zeros((1, 9)), 4)
    np.testing.assert_array_equal(rotation_of(got), [np.eye(3)])
    np.testing.assert_array_almost_equal_nulp(np.abs(got[0, 0]), np.float32(1), 1)  # native roots


@pytest.mark.parametrize("ratios", [(1, 0.7, 0.4), (1, 0.5, 0), (1, 0.3, -0.2), (1, 0.03, 0.01)])
def test_the_largest_root(of, ratios, rng):
    """Of Horn's matrix, less 1: the sum of singular values, the last with the sign of det."""
    c, _ = covariances(rng, np.array(ratios) / np.linalg.norm(ratios))
    body = f"{matrix('c')} real slope; r[0] = largest_root(&c, &slope);"
    got = of(ROTATION, body, c.reshape(-1, 9), 1)[:, 0]
    truth = sum(ratios) / np.linalg.norm(ratios) - 1
    # near a line the root meets another: its square has the digits
    assert (np.abs(got - truth) <= 5e-7 / truth).all()


def test_a_line_is_turned_without_twist(of, rng):
    p, q = units(rng, (COUNT, 3)), units(rng, (COUNT, 3))
    body = f"""quaternion_t q = line_rotation({AXES}, (vec){{a[3], a[4], a[5]}},
    (float4)(0, 0, 1, 0)); {results("q", "wxyz")}"""
    got = of(ROTATION, body, np.hstack([p, q]), 4)
    turned = np.einsum("nij,nj->ni", rotation_of(got), q)
    clear = np.linalg.norm(p + q, axis=1) > 0.05
    np.testing.assert_allclose(turned[clear], p[clear], atol=3e-6)
    axis = got[:, 1:].astype(float)
    assert (np.abs(np.sum(axis * p, axis=1))[clear] <= 2e-6).all()  # normal to both lines


def test_a_line_that_is_turned_round_turns_about_the_axis_given(of):
    line = [[1, 0, 0, -1, 0, 0]]
    body = f"""quaternion_t q = line_rotation({AXES}, (vec){{a[3], a[4], a[5]}},
    (float4)(0, 0, 1, 0)); {results("q", "wxyz")}"""
    np.testing.assert_allclose(of(ROTATION, body, line, 4), [[0, 0, 0, 1]], atol=1e-6)


def test_a_mirror_takes_its_vector_to_the_x_axis(of, rng):
    x = units(rng, (COUNT, 6)) * 10 ** rng.uniform(-3, 3, (COUNT, 1))
    body = f"""vec n = mirror_of({AXES}), x = mirrored(n, {AXES}),
    y = mirrored(n, (vec){{a[3], a[4], a[5]}});
    {results("x", "xyz")} r[3] = y.x; r[4] = y.y; r[5] = y.z;"""
    got = of(ROTATION, body, x, 6)
    length, other = np.linalg.norm(x[:, :3], axis=1), np.linalg.norm(x[:, 3:], axis=1)
    assert (np.abs(got[:, 1:3]).max(axis=1) <= 1e-6 * length).all()
    np.testing.assert_allclose(np.abs(got[:, 0]), length, rtol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(got[:, 3:], axis=1), other, rtol=2e-6)


@pytest.mark.parametrize(("degree", "functions"), [(1, 3), (2, 9), (3, 19)])
def test_monomials(of, degree, functions, rng):
    """Differences keep their digits when the points are near each other."""
    q = rng.uniform(-1, 1, (COUNT, 3)).astype(np.float32)
    x = np.float32(units(rng, (COUNT, 3)) * 10 ** rng.uniform(-6, 0, (COUNT, 1)))
    v = np.float32(q + x)
    x = (v.astype(float) - q).astype(np.float32)
    is_exact = (v.astype(float) - q == x).all(axis=1)
    rows = np.hstack([x, v, q])[is_exact]
    body = """vec x = {a[0], a[1], a[2]}, v = {a[3], a[4], a[5]}, q = {a[6], a[7], a[8]};
    real m[MONOMIALS]; monomial_differences(x, v, q, m);
    for (int i = 0; i < MONOMIALS; ++i) r[i] = m[i];
    for (int axis = 0; axis < 3; ++axis) { monomial_slopes(v, axis, m);
      for (int i = 0; i < MONOMIALS; ++i) r[MONOMIALS * (1 + axis) + i] = m[i]; }"""
    files = ["basis.cl"]
    got = of(files, body, rows, 4 * functions, **Polynomial(degree).constants())
    x, v, q = (rows[:, i : i + 3].astype(float) for i in (0, 3, 6))
    truth = monomial_values(v, degree) - monomial_values(q, degree)
    size = np.abs(x).max(axis=1, keepdims=True)
    assert (np.abs(got[:, :functions] - truth) <= 2e-6 * size).all()
    slopes = np.moveaxis(monomial_gradients(v, degree), 2, 1).reshape(len(v), -1)
    np.testing.assert_allclose(got[:, functions:], slopes, atol=2e-6)


def test_points_of_a_grid(of):
    """Whatever the row is that a vector begins in, also in rows shorter than it."""
    for nx, ny in ((1, 1), (3, 2), (7, 5), (40, 3)):
        first = np.repeat(np.arange(97.0), 16)[:, None]
        body = f"""grid_t grid = {{0, 100000, {nx}, {ny}, {{5, -2, 3}}}};
        vec at = grid_index(&grid, (long)LANE(a[0], 0)); {results("at", "xyz")}"""
        got = of(["grid.cl"], body, first, 3)
        lanes = of.args[1]
        n = first[:, 0].astype(int) + np.arange(len(first)) % lanes
        truth = np.column_stack([n % nx + 5, n // nx % ny - 2, n // nx // ny + 3])
        np.testing.assert_array_equal(got, truth)


def test_affine_transforms(of, rng):
    t, x = rng.normal(size=12).astype(np.float32), rng.normal(size=(COUNT, 3)).astype(np.float32)
    body = f"""float t[12]; for (int i = 0; i < 12; ++i) t[i] = table[i];
    vec y = transformed(t, {AXES}); {results("y", "xyz")}"""
    got = of(["grid.cl"], body, x, 3, table=t)
    columns = t.reshape(4, 3).astype(float)
    np.testing.assert_allclose(got, x.astype(float) @ columns[:3] + columns[3], atol=3e-6)


EACH_SHAPE = Deformation(
    [(0, 0, 0)],
    [(0, 0, 1)],
    cuts=[HalfPlane((0, 0, 0), (1, 0, 0), (0, 1, 0)), Surface.polygon(np.eye(3))],
)
CUTS = {"TWICE_ALPHA": 2, **dict(cut_tables(EACH_SHAPE, EACH_SHAPE.regions[0])[0])}
CUT_FILES = ["powers.cl", "cuts.cl"]
V_AND_Q = "vec v = {a[0], a[1], a[2]}, q = {a[3], a[4], a[5]};"
SHARES = np.linspace(0, 1, 201)


def half_plane(rng):
    """Point of the edge, normal, inward, along."""
    turn = random_rotation(rng)
    return np.concatenate([rng.uniform(-0.3, 0.3, 3), turn[0], turn[1], turn[2]])


def test_a_detour_round_a_half_plane_is_the_shortest(of, rng):
    table = half_plane(rng)
    x = rng.uniform(-1, 1, (COUNT, 6))
    body = f"""{V_AND_Q} frame_t b = half_plane_point(table, q), f = half_plane_point(table, v);
    vec at; r[0] = sqrt(half_plane_detour(table, f, b, &at));
    r[1] = at.x; r[2] = at.y; r[3] = at.z;
    r[4] = select((real)(0), (real)(1), half_plane_blocks(table, f, b) != 0);"""
    got = of(CUT_FILES, body, x, 5, table=table, **CUTS).astype(float)
    v, q = x[:, :3], x[:, 3:]
    point, normal, inward, along = table.reshape(4, 3)
    bend = got[:, 1:4]
    length = np.linalg.norm(v - bend, axis=1) + np.linalg.norm(q - bend, axis=1)
    np.testing.assert_allclose(length, got[:, 0], atol=2e-6)
    np.testing.assert_allclose(np.cross(bend - point, along), 0, atol=2e-6)  # on the edge
    # no point of the edge is on a shorter path
    for place in np.linspace(-2, 2, 401):
        other = point + place * along
        path = np.linalg.norm(v - other, axis=1) + np.linalg.norm(q - other, axis=1)
        assert (got[:, 0] <= path + 2e-6).all()
    # where the segment crosses the plane, and on which side of the edge
    a, b = (v - point) @ normal, (q - point) @ normal
    at = v + (a / (a - b))[:, None] * (q - v)
    depth = (at - point) @ inward
    clear = (np.abs(depth) > 1e-5) & (np.minimum(np.abs(a), np.abs(b)) > 1e-5)
    np.testing.assert_array_equal(got[clear, 4], ((a * b < 0) & (depth > 0))[clear])


def test_a_detour_over_an_edge_is_the_shortest(of, rng):
    edge, x = rng.uniform(-1, 1, (2, 3)), rng.uniform(-1, 1, (COUNT, 6))
    body = f"{V_AND_Q} vec at = bend_on_edge(table, v, q); {results('at', 'xyz')}"
    bend = of(CUT_FILES, body, x, 3, table=edge.ravel(), **CUTS).astype(float)

    def length(places):
        return sum(np.linalg.norm(places - x[:, i : i + 3], axis=-1) for i in (0, 3))

    lengths = [length(edge[0] + share * (edge[1] - edge[0])) for share in SHARES]
    assert (length(bend) <= np.min(lengths, axis=0) + 2e-6).all()
    along = (bend - edge[0]) @ (edge[1] - edge[0]) / np.sum((edge[1] - edge[0]) ** 2)
    assert ((along >= -1e-5) & (along <= 1 + 1e-5)).all()
    np.testing.assert_allclose(edge[0] + along[:, None] * (edge[1] - edge[0]), bend, atol=2e-6)


def test_a_segment_through_a_shared_edge_crosses_one_triangle(of, rng):
    """A fan of triangles: a segment through it passes just one, also through its edges and tip."""
    rim = np.column_stack([*np.array([np.cos(t := np.arange(7) * 0.8), np.sin(t)]), 0.1 * t])
    fan = np.stack([[(0, 0, 0), a, b] for a, b in itertools.pairwise(rim)]).astype(np.float32)
    through = np.concatenate([fan[:, 0] * 0, (fan[:, 1] + fan[:, 0]) / 2, fan.mean(axis=1)])
    away = units(rng, (len(through), 3)) + [0, 0, 3]
    x = np.hstack([through - away, through + away])
    body = f"""{V_AND_Q} for (int i = 0; i < {len(fan)}; ++i)
    r[0] += select((real)(0), (real)(1), crosses_triangle(table + 9 * i, v, q) != 0);"""
    inside = slice(2, len(through))  # the fan does not close at its first rim
    got = of(CUT_FILES, body, x, 1, table=fan.ravel(), **CUTS)[inside, 0]
    assert set(got.tolist()) <= {0.0, 1.0}
    assert (got[-len(fan) :] == 1).all()


def test_distances_to_triangles(of, rng):
    corners, x = rng.uniform(-1, 1, (3, 3)), rng.uniform(-2, 2, (300, 3))
    body = f"r[0] = distance_to_triangle(table, {AXES});"
    got = of(CUT_FILES, body, x, 1, table=corners.ravel(), **CUTS)[:, 0]
    s, t = (shares.ravel() for shares in np.meshgrid(SHARES, SHARES))
    s, t = s[s + t <= 1], t[s + t <= 1]
    filled = (
        corners[0] + s[:, None] * (corners[1] - corners[0]) + t[:, None] * (corners[2] - corners[0])
    )
    near = np.linalg.norm(x[:, None] - filled, axis=-1).min(axis=1)
    assert (got <= near + 2e-6).all()
    assert (got >= near - 0.02).all()  # what a step of the samples leaves


def test_distances_of_segments(of, rng):
    edge, x = rng.uniform(-1, 1, (2, 3)), rng.uniform(-1, 1, (300, 6))
    x[0, 3:] = x[0, :3] + 2 * (edge[1] - edge[0])  # parallel
    body = f"{V_AND_Q} r[0] = distance_of_segments(v, q, table);"
    got = of(CUT_FILES, body, x, 1, table=edge.ravel(), **CUTS)[:, 0]
    on_edge = edge[0] + SHARES[:, None] * (edge[1] - edge[0])
    on_way = x[:, None, :3] + SHARES[:, None] * (x[:, 3:] - x[:, :3])[:, None]
    near = np.linalg.norm(on_way[:, :, None] - on_edge, axis=-1).min(axis=(1, 2))
    assert (got <= near + 2e-6).all()
    assert (got >= near - 0.02).all()
