"""Each small function of the kernels alone, against float64, with the bound of its comment.

Structs and constants are those of the host.
"""

import itertools
import re
import warnings
from functools import partial

import numpy as np
import pyopencl as cl
import pytest
from control_point_sets import DEVICES, OTHER_DEVICES, random_rotation

from vtk_mls import Deformation, Surface
from vtk_mls.engine import dispatch
from vtk_mls.engine.device import devices as device
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, STRUCTS
from vtk_mls.engine.map.cut_tables import cut_tables
from vtk_mls.queries import void_cells

ROTATION = ["rotation.cl"]
COUNT = 2000
_KERNEL = """
__kernel EXPLICIT_VECTORS void call(__global const float *table, const long count,
                                    __global const float *in, __global float *out) {{
  long first = (long)get_global_id(0) * LANES;
  real a[{inputs}], r[{outputs}];
  for (int i = 0; i < {inputs}; ++i) a[i] = LOAD(in + i * count + first);
  for (int i = 0; i < {outputs}; ++i) r[i] = 0;
  {body}
  for (int i = 0; i < {outputs}; ++i) STORE(r[i], out + i * count + first);
}}
"""


def built(chosen, text):
    """A program, without the output of the compiler."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return cl.Program(device.context(chosen), text).build(options=["-w"])


def call(chosen, lanes, files, body, arguments, outputs, table=(0.0,), **constants):
    """Numbers (n, outputs) float32 that OpenCL C leaves in `r`, for each row of arguments `a`.

    `files` of opencl/ are included beside types.cl; a work item computes `lanes` rows. OpenCL C may
    read the floats `table`, too.
    """
    rows = np.asarray(arguments, np.float32)
    padded = np.resize(rows, (-(-len(rows) // 16) * 16, rows.shape[1]))
    macros = tuple({"LANES": lanes, **constants}.items())
    text = "\n".join(device.source(name, macros) for name in ("types.cl", *files))
    text += _KERNEL.format(inputs=rows.shape[1], outputs=outputs, body=body)
    context, queue, flags = device.context(chosen), device.queue(chosen), cl.mem_flags
    kernel = built(chosen, text).call
    tables, planes = (
        cl.Buffer(context, flags.COPY_HOST_PTR, hostbuf=np.ascontiguousarray(array, np.float32))
        for array in (table, padded.T)
    )
    result = np.empty((outputs, len(padded)), np.float32)
    out = cl.Buffer(context, flags.WRITE_ONLY, result.nbytes)
    kernel(queue, (len(padded) // lanes,), None, tables, np.int64(len(padded)), planes, out)
    cl.enqueue_copy(queue, result, out)
    return result.T[: len(rows)]


@pytest.fixture(params=list(itertools.product(DEVICES, ["vectors", "scalars"])), ids=str)
def of(request):
    """`call` on a device, a point or a vector of them at a time."""
    key, lanes = request.param
    chosen = dispatch.choose(key)
    return partial(call, chosen, chosen.lanes if lanes == "vectors" else 1)


# A matrix of the elements of `a`, and the quaternion of its rotation.
MATRIX = f"mat c = {{{{{', '.join(f'a[{i}]' for i in range(9))}}}}}; real slope;"
FIT = f"""{MATRIX} quaternion_t q = whole_rotation(&c, &slope);
r[0] = q.w; r[1] = q.x; r[2] = q.y; r[3] = q.z;"""


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


def test_a_small_turn_has_all_its_digits(of, rng):
    """R - I is computed as such, not as a difference."""
    angle = 10 ** rng.uniform(-12, -3, COUNT)
    axis = units(rng, (COUNT, 3))
    q = np.column_stack([np.cos(angle / 2), np.sin(angle / 2)[:, None] * axis])
    turned = "rotation_change((quaternion_t){a[0], a[1], a[2], a[3]})"
    got = of(ROTATION, f"mat m = {turned}; r[0] = m.a[1]; r[1] = m.a[2];", q, 2)
    truth = np.column_stack([-axis[:, 2], axis[:, 1]]) * angle[:, None]
    assert (np.abs(got - truth).max(axis=1) <= 1e-6 * angle + angle**2).all()


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
    got = of(ROTATION, FIT, c.reshape(-1, 9), 4)
    np.testing.assert_allclose(rotation_of(got), truth, atol=bound)


def test_no_covariance_is_no_rotation(of):
    got = of(ROTATION, FIT, np.zeros((1, 9)), 4)
    np.testing.assert_array_equal(rotation_of(got), [np.eye(3)])
    np.testing.assert_array_almost_equal_nulp(np.abs(got[0, 0]), np.float32(1), 1)  # native roots


@pytest.mark.parametrize("ratios", [(1, 0.7, 0.4), (1, 0.5, 0), (1, 0.3, -0.2), (1, 0.03, 0.01)])
def test_the_largest_root(of, ratios, rng):
    """Of Horn's matrix, less 1: the sum of singular values, the last with the sign of det."""
    c, _ = covariances(rng, np.array(ratios) / np.linalg.norm(ratios))
    got = of(ROTATION, f"{MATRIX} r[0] = largest_root(&c, &slope);", c.reshape(-1, 9), 1)[:, 0]
    truth = sum(ratios) / np.linalg.norm(ratios) - 1
    # near a line the root meets another: its square has the digits
    assert (np.abs(got - truth) <= 5e-7 / truth).all()


SURFACE = Deformation([(0, 0, 0)], [(0, 0, 1)], cuts=Surface.polygon(np.eye(3)))
CUTS = {"TWICE_ALPHA": 2, **dict(cut_tables(SURFACE, SURFACE.regions[0])[0])}
CUT_FILES = ["powers.cl", "cuts.cl"]
V_AND_Q = "vec v = {a[0], a[1], a[2]}, q = {a[3], a[4], a[5]};"
SHARES = np.linspace(0, 1, 201)


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
    body = "r[0] = distance_to_triangle(table, (vec){a[0], a[1], a[2]});"
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


# Structs and constants


@pytest.mark.parametrize("key", [*DEVICES, *OTHER_DEVICES])
def test_structs_are_laid_out_alike_on_host_and_device(key):
    expected, lines = [], []
    for name, dtype in STRUCTS.items():
        lines.append(f"{name} {name}_it; out[{len(expected)}] = (int)sizeof({name}_it);")
        expected.append(dtype.itemsize)
        for member in dtype.names:
            offset = f"(char *)&{name}_it.{member} - (char *)&{name}_it"
            lines.append(f"out[{len(expected)}] = (int)({offset});")
            expected.append(dtype.fields[member][1])
    body = "\n".join(lines)
    text = f"{device.source('structs.h')}\n__kernel void layout(__global int *out) {{ {body} }}"
    chosen = next(found for found in device.list_devices() if found.key == key)
    queue, layout = device.queue(chosen), np.zeros(len(expected), np.int32)
    out = cl.Buffer(device.context(chosen), cl.mem_flags.WRITE_ONLY, layout.nbytes)
    built(chosen, text).layout(queue, (1,), (1,), out)
    cl.enqueue_copy(queue, layout, out)
    np.testing.assert_array_equal(layout, expected)


@pytest.mark.parametrize("dtype", STRUCTS.values(), ids=STRUCTS)
def test_structs_end_with_a_member(dtype):
    """rusticl 22.3 does not count padding at the end."""
    last = dtype.names[-1]
    assert dtype.fields[last][1] + dtype[last].itemsize == dtype.itemsize


@pytest.mark.parametrize("name", ["VOID", "TOUCHED", "UNKNOWN"])
def test_flags_of_void_cells_are_those_of_the_host(name):
    assert CONSTANTS[name] == getattr(void_cells, name)


@pytest.mark.parametrize(("name", "order"), [("tap_weight", 0), ("tap_slope", 1)])
def test_weights_between_nodes_are_those_of_lagrange_polynomials(name, order):
    text = re.search(rf"{name}\[.*?= \{{(.*?)\}};", device.source("coarse_map.cl"), re.DOTALL)[1]
    weights = [float(weight) for weight in re.findall(r"(-?[\d.]+)f", text)]
    nodes, step = np.arange(-2, 4), CONSTANTS["COARSE_STEP"]
    polynomials = [
        np.poly1d(np.delete(nodes, i), r=True) / np.prod(nodes[i] - np.delete(nodes, i))
        for i in range(len(nodes))
    ]
    expected = [
        polynomial.deriv(order)(k / step) / step**order
        for k in range(step)
        for polynomial in polynomials
    ]
    np.testing.assert_allclose(weights, expected, rtol=6e-8, atol=1e-18)
