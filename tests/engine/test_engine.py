"""The kernels against the specification, on every device of this machine."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import (
    DEVICES,
    EXTENT,
    HARD_SETS,
    KINDS_AND_DEGREES,
    OTHER_DEVICES,
    TOLERANCE,
    deformation,
    on_both,
    places,
    random_handles,
)
from drivers import check_kernels
from pairwise import Rare, paired, rare

from vtk_mls import Deformation, Grid, Sampling
from vtk_mls.base import interpolation
from vtk_mls.commands import kernel_checks
from vtk_mls.engine import dispatch
from vtk_mls.engine import opencl_engine as engine
from vtk_mls.engine.device import devices as device
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.launcher import Launcher
from vtk_mls.engine.sample.sampler import Sampler
from vtk_mls.queries.vector_fields import covariant

pytestmark = pytest.mark.skipif(
    not DEVICES, reason="no OpenCL device that computes right: `vtk-mls doctor` says why"
)


def voxels(difference, points):
    """Lengths of `difference` in voxels of a grid of 256 over the extent of `points`."""
    size = max(np.ptp(points, axis=0).max(), 1e-30)
    return np.linalg.norm(difference, axis=-1) / size * EXTENT


@paired(
    kind_and_degree=KINDS_AND_DEGREES,
    count=[15, 200],
    alpha=[0.5, 1.3, 1, *rare(1.5), 2, 3],
    smoothing=[0, 30, *rare(1e-4, 1, 1000)],
)
def test_backward_on_random_sets(key, kind_and_degree, alpha, count, smoothing, rng):
    # 15 handles, smoothed, hardly determine the polynomials of degree 2
    rest, deformed = random_handles(rng, max(count, 60) if smoothing else count)
    v = places(rng, deformed, 2000)
    options = {"alpha": alpha, "smoothing": smoothing}
    expected, got = on_both(key, rest, deformed, kind_and_degree, **options)
    error = voxels(got.backward(v) - expected.backward(v), deformed)
    largest, p99 = TOLERANCE[kind_and_degree]
    assert np.percentile(error, 99) <= p99
    assert error.max() <= largest
    if smoothing:
        slopes = expected.jacobian(v[:300])
        error = np.abs(got.jacobian(v[:300]) - slopes).max(axis=(1, 2))
        error /= np.maximum(1, np.abs(slopes).max(axis=(1, 2)))
        assert np.percentile(error, 97) <= 1e-3


@pytest.mark.parametrize("name", HARD_SETS)
def test_backward_on_hard_sets(key, name, kind_and_degree, rng):
    rest, deformed = HARD_SETS[name](rng)
    v = places(rng, deformed, 300)
    v = v[:400] if name == "ten thousand" else v
    expected, got = (d.backward(v) for d in on_both(key, rest, deformed, kind_and_degree))
    reach = np.concatenate([deformed, expected])
    error = voxels(got - expected, reach)
    p99 = TOLERANCE[kind_and_degree][1]
    # close to a degenerate fit float32 input decides a little less
    assert np.percentile(error, 99) <= 5 * p99
    if name != "reflection":  # the map jumps where two rotations are equally good
        assert error.max() <= 40 * p99


@paired(
    kind_and_degree=KINDS_AND_DEGREES,
    name=[name for name in HARD_SETS if name not in ("reflection", "ten thousand")],
    alpha=[2, 1, *rare(1.7)],
)
def test_jacobian(key, kind_and_degree, name, alpha, rng):
    rest, deformed = HARD_SETS[name](rng)
    v = places(rng, deformed, 200)
    both = on_both(key, rest, deformed, kind_and_degree, alpha=alpha)
    expected, got = (d.jacobian(v) for d in both)
    scale = np.maximum(1, np.abs(expected).max(axis=(1, 2)))
    error = np.abs(got - expected).max(axis=(1, 2)) / scale
    assert np.percentile(error, 95) <= 1e-3
    nearly_open = name.startswith("collinear") or kind_and_degree == ("polynomial", 3)
    assert error.max() <= (1e-2 if nearly_open else 1e-3)


def test_degree_3(key, rng):
    """Other tests leave it to `make matrix`, for most of its code is that of degree 2."""
    rest, deformed = random_handles(rng, 80, 2)
    v = places(rng, deformed, 500)
    expected, got = on_both(key, rest, deformed, ("polynomial", 3))
    x = expected.backward(v)
    error = voxels(got.backward(v) - x, deformed)
    largest, p99 = TOLERANCE["polynomial", 3]
    assert np.percentile(error, 99) <= p99
    assert error.max() <= largest
    slopes = expected.jacobian(v)
    np.testing.assert_allclose(got.jacobian(v), slopes, rtol=0, atol=1e-3 * np.abs(slopes).max())
    inside = (np.linalg.det(slopes) > 0.3) & (np.abs(v / EXTENT - 0.5) < 0.4).all(axis=1)
    assert inside.sum() > 100
    field = got.forward_field(x[inside])
    assert field.found.all()
    origins = expected.backward(x[inside] + field.displacement)
    assert voxels(origins - x[inside], deformed).max() <= 1e-5 * EXTENT


@pytest.mark.parametrize("dimensions", [(1, 1, 1), (1, 7, 1), (3, 1, 50), (17, 5, 4), (64, 3, 3)])
def test_grids_of_every_shape(key, dimensions, rng):
    """Rows shorter and longer than a vector, oriented anyhow."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    grid = Grid(dimensions, (3, 4, 5), (2, 1.5, 3), turn)
    rest, deformed = random_handles(rng, 10, 20)
    d = deformation(rest, deformed, ("rigid", 1), key)
    field = d.displacement_field(dimensions, (3, 4, 5), (2, 1.5, 3), turn)
    assert field.displacement.shape == (*dimensions[::-1], 3)
    assert field.displacement.dtype == np.float32
    expected = d.backward(grid.points()) - grid.points()
    np.testing.assert_allclose(field.displacement.reshape(-1, 3), expected, rtol=0, atol=2e-4)


def test_a_hundred_thousand_control_points(key, rng):
    rest, deformed = random_handles(rng, 100_000, 1)
    v = rng.uniform(0, EXTENT, (40, 3))
    expected, got = (d.backward(v) for d in on_both(key, rest, deformed))
    assert voxels(got - expected, deformed).max() <= 2e-4


def test_small_memory_gives_the_same_in_slabs(key, rng, monkeypatch):
    d = Deformation(*random_handles(rng, 15), device=key)
    grid = Grid((40, 30, 20), spacing=(6, 8, 12))
    image = rng.normal(size=grid.shape).astype(np.float32)
    whole = d.displacement_field(grid.dimensions, spacing=grid.spacing).displacement
    resampled = d.resample([image], grid)[0]
    steps = []
    monkeypatch.setattr(engine.on(dispatch.choose(key)).memory, "limit", 4 * 12 * 2048)
    slabs = d.displacement_field(
        grid.dimensions, spacing=grid.spacing, progress=steps.append
    ).displacement
    assert len(steps) > 5
    assert steps == [*sorted(steps[:-1]), 1]
    np.testing.assert_array_equal(slabs, whole)
    np.testing.assert_array_equal(d.resample([image], grid)[0], resampled)


def test_a_source_larger_than_the_memory_goes_in_slices(key, rng, monkeypatch):
    """As on a GPU, which does not share the host's memory."""
    chosen = engine.on(dispatch.choose(key))
    rest, deformed = random_handles(rng, 15, 4)
    d = deformation(rest, deformed, ("rigid", 1), key)
    grid = Grid((24, 22, 60), spacing=(11, 12, 4)).part((2, 1, 5), (20, 20, 50))
    image = rng.normal(size=(*grid.shape, 2))
    whole = d.resample([image], Sampling(grid, interpolation="cubic"))[0]
    monkeypatch.setattr(chosen.memory, "in_place", False)
    vectors = rng.normal(size=(*grid.shape, 3)).astype(np.float32)
    gradients = d.resample_gradients(vectors, grid)
    monkeypatch.setattr(chosen.memory, "limit", image.nbytes)
    np.testing.assert_array_equal(
        d.resample([image], Sampling(grid, interpolation="cubic"))[0], whole
    )
    np.testing.assert_array_equal(d.resample_gradients(vectors, grid), gradients)


@paired(
    name=[name for name in HARD_SETS if name[:2] != "at"],
    kind_and_degree=KINDS_AND_DEGREES,
    alpha=[2, 1, *rare(3)],
)
def test_covariant_vectors_are_products_with_the_jacobian(key, name, alpha, kind_and_degree, rng):
    """Kernels sum these products without a Jacobian where a map has only control points."""
    d = deformation(*HARD_SETS[name](rng), kind_and_degree, key, alpha=alpha)
    source = Grid((2, 2, 2), (-1e6,) * 3, (2e6,) * 3)  # everywhere
    target = Grid((18, 11, 13), (-8.0, 265.0, 3.0), (15.7, -26.6, 21.6))
    vector = rng.normal(size=3)
    constant = np.tile(vector.astype(np.float32), (2, 2, 2, 1))
    got = d.resample_gradients(constant, Sampling(source, target)).reshape(-1, 3)
    jacobian = d.jacobian(target.points())
    size = np.maximum(1, np.abs(jacobian).max(axis=(1, 2)))
    error = np.abs(got - jacobian.swapaxes(1, 2) @ vector).max(axis=1)
    assert (error / size).max() < 1e-3


@paired(
    width=[1, 16, 4, *rare(2, 8)],
    method=["nearest", "linear", "cubic"],
    normalise=[False, True],
)
def test_a_vector_does_not_depend_on_its_neighbors(key, width, method, normalise, rng):
    """Vectors at borders, on grid points and outside take another branch than the others."""
    chosen = engine.Engine(replace(dispatch.choose(key), width=width))
    handles, grid = random_handles(rng, 9), Grid((9, 8, 7), spacing=(25, 30, 35))
    target = Grid((37, 13, 11), (-30, -25, -20), (8, 25, 28))
    vectors = rng.normal(size=(*grid.shape, 3)).astype(np.float32)

    def transformed(target):
        sampling = Sampling(grid, target=target, interpolation=method)
        return chosen.resample(d, [vectors], sampling, covariant={0: normalise})[0]

    for rest, deformed in (handles, (handles[1], handles[1])):
        d = deformation(rest, deformed, ("rigid", 1))
        whole = transformed(target)
        for first in (1, 6):
            part = transformed(target.part((first, 1, 2), (25, 9, 7)))
            np.testing.assert_array_equal(part, whole[2:9, 1:10, first : first + 25])
        index = grid.index_of(d.backward(target.points()))
        outside = ~grid.covers(index)
        assert outside.sum() > 500
        # rounding decides about the nearest point, and at the border
        is_clear = np.all(np.abs(index % 1 - 0.5) > 1e-3, axis=1)
        specified = interpolation.sample(vectors, index, method, 0, grid)
        specified = covariant(specified, d.jacobian(target.points()).swapaxes(1, 2), normalise)
        is_clear &= np.linalg.norm(specified, axis=1) > 0.01  # else without a direction
        got = whole.reshape(-1, 3)
        np.testing.assert_allclose(got[is_clear], specified[is_clear], atol=1e-3)
        assert is_clear.sum() > 1000


@paired(
    width=[1, 16, 4, *rare(2, 8)],
    method=["nearest", "linear", "cubic"],
    dtype=["uint8", "int32", "float32"],
    components=[1, 3],
)
def test_a_value_does_not_depend_on_its_neighbors(key, width, method, dtype, components, rng):
    """Points at borders, on grid points and outside take another branch than the others."""
    launcher = Launcher(replace(dispatch.choose(key), width=width))
    grid = Grid((9, 8, 7))
    array = rng.integers(0, 200, (*grid.shape, components)).astype(dtype)
    sampler = Sampler(launcher, array, grid, fits=True, method=method, background=9)
    index = rng.uniform(-1, 10, (2000, 3)).astype(np.float32)
    index[::5] = np.round(index[::5])
    index[::7, 1] = np.nan

    def sampled(order):
        result = np.empty((len(order), components), dtype)
        with launcher.memory.input_buffer(kernel_arguments.planes(index[order])) as buffer:
            sampler.sample(buffer, result)
        return result

    expected = sampled(np.arange(len(index)))
    between = np.flatnonzero(np.all((index > 1) & (index < 6) & (index % 1 > 0), axis=1))
    assert len(between) > 100
    np.testing.assert_array_equal(sampled(between), expected[between])
    order = rng.permutation(len(index))
    np.testing.assert_array_equal(sampled(order), expected[order])
    np.testing.assert_array_equal(expected[::7], 9)
    specified = interpolation.sample(array, index.astype(np.float64), method, 9, grid)
    np.testing.assert_allclose(
        expected, specified, rtol=1e-6, atol=1 if dtype != "float32" else 1e-4
    )


def test_a_source_that_cannot_fit_is_refused(key, rng, monkeypatch):
    chosen = engine.on(dispatch.choose(key))
    d = deformation(*random_handles(rng, 5), ("rigid", 1), key)
    grid = Grid((50, 50, 4))
    monkeypatch.setattr(chosen.memory, "in_place", False)
    monkeypatch.setattr(chosen.memory, "limit", 1000)
    with pytest.raises(device.DeviceError, match="do not fit the memory"):
        d.resample([np.zeros(grid.shape)], grid)


def test_moved_handles_do_not_rebuild_kernels(key, rng, monkeypatch):
    d = deformation(*random_handles(rng, 15), ("rigid", 1), key)
    d.backward([[1, 2, 3]])
    built = []
    monkeypatch.setattr(device, "_built", lambda *arguments: built.append(arguments))
    for count in (15, 16, 700):
        deformation(*random_handles(rng, count), ("rigid", 1), key).backward([[1, 2, 3]])
    assert not built


def test_calls_wait_for_each_other(key, rng):
    """Arguments of a kernel belong to one launch at a time."""
    d, v = Deformation(*random_handles(rng, 5), device=key), rng.uniform(0, EXTENT, (10, 3))
    d.backward(v)  # builds the kernels
    answered, waits = threading.Event(), []

    def ask():
        d.backward(v)
        answered.set()

    def progress(fraction):
        if not waits:
            other.start()
            waits.append(answered.wait(0.5))

    other = threading.Thread(target=ask)
    d.displacement_field((8, 8, 8), progress=progress)
    other.join()
    assert waits == [False]
    assert answered.is_set()


# Other kinds have the same fit of a rotation or of polynomials.
BOTH_FITS = [
    pair if pair in (("rigid", 1), ("polynomial", 2)) else Rare(pair) for pair in KINDS_AND_DEGREES
]


@paired(kind_and_degree=BOTH_FITS, alpha=[2, 1])
def test_a_device_without_float64(key, kind_and_degree, alpha, rng, monkeypatch):
    """Sums are taken in float32 then: enough while no few control points outweigh the others."""
    monkeypatch.setattr(device.Device, "has_float64", property(lambda self: False))
    rest, deformed = random_handles(rng, 25)
    v = places(rng, deformed, 300)
    expected, got = on_both(key, rest, deformed, kind_and_degree, alpha=alpha)
    error = voxels(got.backward(v) - expected.backward(v), deformed)
    assert np.percentile(error, 99) <= TOLERANCE[kind_and_degree][1] * (1 if alpha == 1 else 50)
    x = expected.backward(v)
    found = got.forward(x)
    is_found = ~np.isnan(found[:, 0])
    assert is_found.mean() > 0.95
    miss = voxels(expected.backward(found[is_found]) - x[is_found], deformed)
    assert np.percentile(miss, 99) <= 1e-4 * EXTENT


def test_numpy_computes_a_spline_that_a_device_without_float64_cannot(
    key, rng, monkeypatch, caplog
):
    monkeypatch.setattr(device.Device, "has_float64", property(lambda self: False))
    deformed = rng.uniform(0, EXTENT, (200, 3))
    rest = deformed + 8 * np.sin(deformed[:, [1, 2, 0]] / 60)
    expected, got = on_both(key, rest, deformed, ("spline", 2), order=1, softening=EXTENT)
    found = got.backward(deformed)
    assert "has no double precision, which this spline needs: numpy is used" in caplog.text
    np.testing.assert_array_equal(found, expected.backward(deformed))


REQUIRED = {
    *("point_displacement", "point_jacobian", "point_inverse", "grid_displacement"),
    *("point_forward", "lattice_cells", "local_points", "node_origin", "node_cell"),
    *("grid_source_index", "resample", "gradient", "void_by_corners"),
    *("node_displacement", "coarse_check", "coarse_displacement", "coarse_source_index"),
}


def test_the_check_of_a_device_launches_kernels_of_every_sort(key, launched):
    used = engine.Engine(dispatch.choose(key))
    for checks in kernel_checks.checks(used).values():
        for _, results, bound in checks:
            assert kernel_checks.error(used, results) <= bound
    assert dict(launched).keys() >= REQUIRED


FEW_STEPS = "affine, half-plane: points", "images, linear"


@pytest.mark.skipif(not OTHER_DEVICES, reason="no second OpenCL device of a kind")
@pytest.mark.parametrize("key", OTHER_DEVICES or [None])
@pytest.mark.parametrize(
    "selected",
    [pytest.param(FEW_STEPS, id="few"), pytest.param((), id="all", marks=pytest.mark.matrix)],
)
def test_every_other_device(key, selected):
    """Each kernel, kind and cut once, at the checked width of the device."""
    other = engine.Engine(dispatch.choose(key))
    steps = dict(check_kernels.steps(other))
    for name in selected or steps:
        assert check_kernels.worst(name, steps[name]()) <= check_kernels.BOUND, name
