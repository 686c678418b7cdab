"""Images through the map: on the specification and on each device."""

from itertools import product

import numpy as np
import pytest
from control_point_sets import DEVICES, random_rotation
from scipy.ndimage import map_coordinates

from vtk_mls import INTERPOLATIONS, Deformation, Grid, HalfPlane, Sampling

DTYPES = [f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)]
DTYPES += ["float32", "float64"]


def random_array(rng, dtype, shape):
    if dtype.startswith("f"):
        return rng.normal(size=shape).astype(dtype)
    limits = np.iinfo(dtype)
    return rng.integers(limits.min, limits.max, shape, dtype=dtype, endpoint=True)


def oriented_grid(rng, dimensions=(23, 17, 12)):
    return Grid(dimensions, (30, -20, 5), (1.5, 0.7, 2), random_rotation(rng))


def handles_in(grid, rng, count=12, shift=2.0):
    deformed = grid.at(rng.uniform(0, 1, (count, 3)) * grid.dimensions)
    return deformed + rng.normal(0, shift, (count, 3)), deformed


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_the_identity_keeps_every_bit(device, dtype, interpolation, rng):
    grid = oriented_grid(rng)
    image, vectors = (random_array(rng, dtype, grid.shape + c) for c in ((), (3,)))
    if dtype.startswith("f"):
        image.flat[:4] = np.nan, np.inf, -np.inf, -0.0
    handles = handles_in(grid, rng)[1]
    d = Deformation(handles, handles, device=device)
    for given, got in zip(
        (image, vectors), d.resample([image, vectors], Sampling(grid, interpolation=interpolation))
    ):
        assert got.dtype == given.dtype
        assert got.tobytes() == given.tobytes()


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_devices_agree_with_the_specification(key, dtype, interpolation, rng):
    grid = oriented_grid(rng)
    arrays = [random_array(rng, dtype, grid.shape + c) for c in ((), (2,))]
    handles = handles_in(grid, rng)
    expected, got = (
        Deformation(*handles, device=name).resample(
            arrays, Sampling(grid, interpolation=interpolation, background=7)
        )
        for name in ("reference", key)
    )
    for a, b in zip(expected, got):
        size = float(arrays[0].max()) - float(arrays[0].min())
        error = np.abs(a.astype(float) - b.astype(float))
        # the last digit of a rounded integer can go either way
        allowed = 2e-5 * size + (1 if dtype[0] in "iu" else 0)
        assert np.mean(error > allowed) <= (2e-3 if interpolation == "nearest" else 1e-4)


def test_linear_functions_come_through_exactly(device, rng):
    """A ramp sampled through the map is the ramp of the map."""
    grid = oriented_grid(rng)
    ramp = (grid.points() @ [0.3, -0.2, 0.5] + 4).reshape(grid.shape)
    d = Deformation(*handles_in(grid, rng), "similarity", device=device)
    expected = (d.backward(grid.points()) @ [0.3, -0.2, 0.5] + 4).reshape(grid.shape)
    index = grid.index_of(d.backward(grid.points())).reshape(*grid.shape, 3)
    margins = {"linear": 0, "cubic": 1}
    for interpolation, margin in margins.items():
        inside = (index >= margin) & (index <= np.array(grid.dimensions) - 1 - margin)
        inside = inside.all(axis=-1)
        assert inside.mean() > 0.2
        got = d.resample([ramp], Sampling(grid, interpolation=interpolation))[0]
        np.testing.assert_allclose(got[inside], expected[inside], rtol=0, atol=1e-4)


def test_background_begins_half_a_voxel_outside(device):
    grid = Grid((3, 1, 1))
    image = np.array([1.0, 2.0, 3.0]).reshape(grid.shape)
    d = Deformation([[0, 0, 0]], [[0, 0, 0]], device=device)
    target = Grid((9, 1, 1), origin=(-0.95, 0, 0), spacing=(0.5, 1, 1))
    for interpolation in INTERPOLATIONS:
        (got,) = d.resample([image], Sampling(grid, target, interpolation, background=-5))
        # at -0.95, -0.45, 0.05, 0.55, ..., 2.05, 2.55, 3.05
        np.testing.assert_array_equal(got.ravel()[[0, 1, 7, 8]], [-5, 1, -5, -5])
        assert got.ravel()[6] == pytest.approx(3)


@pytest.mark.parametrize(
    ("dtype", "background", "replaced"),
    [
        ("uint8", -1000, 0),
        ("int16", 1e9, 32767),
        ("int32", np.nan, 0),
        ("uint64", -1, 0),
        ("int64", np.inf, 2**63 - 1),
        ("float32", 1e300, np.inf),
        ("uint8", 0, None),
        ("uint8", 255, None),
        ("uint8", 7.4, None),
        ("int64", 2**62 + 1, None),
        ("float32", np.nan, None),
    ],
)
def test_a_background_outside_the_range_of_a_type_is_reported(
    device, dtype, background, replaced, caplog
):
    d = Deformation([[100, 0, 0]], [[0, 0, 0]], device=device)
    grid = Grid((2, 2, 2))
    arrays = [np.ones(grid.shape), np.ones(grid.shape, dtype)]
    caplog.clear()
    wide, got = d.resample(arrays, Sampling(grid, background=background))
    expected = np.array(background).astype(dtype) if replaced is None else replaced
    np.testing.assert_array_equal(got, np.full(grid.shape, expected, dtype))
    np.testing.assert_array_equal(wide, np.full(grid.shape, float(background)))
    assert len(caplog.messages) == (replaced is not None)
    for line in caplog.messages:
        assert f"got {background!r}: array 1 ({dtype}) gets {got.flat[0]} instead" in line
        assert line.startswith("`background` must be in the range of each array's type")


def ends_of(dtype):
    """Values at which sums lose digits or end."""
    if np.dtype(dtype).kind == "f":
        return [101325.0, 4_500_000.3, -1 / 3] + [1e300, np.finfo(float).max] * (dtype == "float64")
    low, high = int(np.iinfo(dtype).min), int(np.iinfo(dtype).max)
    values = 123456789, 2**40 + 1, 2**53 + 1, 2**62 + 1, -(2**53) - 1
    return [low, low + 1, high // 2, high - 1, high, *(v for v in values if low <= v <= high)]


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("options", [{}, {"map_tolerance": 0.05}, {"cuts": True}], ids=str)
def test_a_constant_stays_constant(device, dtype, interpolation, options, rng):
    """Also at borders, and with the background of the void and of what is outside."""
    grid = oriented_grid(rng)
    middle = grid.at([np.array(grid.dimensions) / 2])[0]
    if "cuts" in options:
        options = {"cuts": HalfPlane(middle, (1, 0.2, 0), (0, 0.1, 1))}
    d = Deformation(*handles_in(grid, rng), device=device, **options)
    for value in ends_of(dtype):
        given = [np.full(grid.shape + c, value, dtype) for c in ((), (3,))]
        sampling = Sampling(grid, interpolation=interpolation, background=given[0].item(0))
        for a, b in zip(given, d.resample(given, sampling)):
            # float32 is summed in float32: 8 or 64 roundings
            rounding = 8 * np.spacing(abs(a[0, 0, 0])) if dtype == "float32" else 0
            np.testing.assert_allclose(b, a, rtol=0, atol=np.max(rounding))
            assert b.dtype == a.dtype


@pytest.mark.parametrize("dtype", ["int32", "uint32", "int64", "uint64", "float64"])
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_sums_have_the_digits_of_float64(device, dtype, interpolation, rng):
    """Against sums of long doubles, at places that float32 has, for values of all sizes."""
    grid = Grid((8, 7, 9))
    values = random_array(rng, dtype, grid.shape)
    d = Deformation([[0, 0, 0]], [[0, 0, 0]], device=device)
    index = rng.uniform(0, np.array(grid.dimensions) - 1, (20, 3)).astype(np.float32).astype(float)
    targets = [Grid((1, 1, 1), place) for place in index]
    got = [d.resample([values], Sampling(grid, target, interpolation))[0] for target in targets]
    got = np.ravel(got)
    size = float(values.max()) - float(values.min())
    # of which the sum of the weights' sizes is at most 2
    allowed = 8 * np.finfo(float).eps * size + (0.5 if dtype[0] in "iu" else 0)
    exact = exact_sums(values, index, interpolation)
    if dtype[0] in "iu":
        low, high = (np.longdouble(int(end)) for end in (np.iinfo(dtype).min, np.iinfo(dtype).max))
        exact = np.clip(exact, low, high)
    assert np.abs(got.astype(np.longdouble) - exact).max() <= allowed
    if interpolation == "linear" and dtype in ("int32", "float64"):
        oracle = map_coordinates(values.astype(float), index[:, ::-1].T, order=1)
        np.testing.assert_allclose(got, oracle, rtol=0, atol=allowed)


def exact_sums(values, index, interpolation):
    base = np.floor(index).astype(int)
    t = (index - base).astype(np.longdouble)
    weights = {0: 1 - t, 1: t}
    if interpolation == "cubic":
        weights = {
            -1: -t * (1 - t) ** 2 / 2,
            0: (3 * t**3 - 5 * t**2 + 2) / 2,
            1: (-3 * t**3 + 4 * t**2 + t) / 2,
            2: t**2 * (t - 1) / 2,
        }
    total = np.zeros(len(index), np.longdouble)
    for taps in product(weights, repeat=3):
        at = np.clip(base + taps, 0, np.array(values.shape[::-1]) - 1)
        weight = np.prod([weights[tap][:, axis] for axis, tap in enumerate(taps)], axis=0)
        total += weight * values[tuple(at.T[::-1])].astype(np.longdouble)
    return total


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_spread_where_they_have_weight(
    device, dtype, interpolation, value
):
    """Whatever the other axes do; where it has none, the others show."""
    grid = Grid((9, 9, 9))
    values = np.ones(grid.shape, dtype)
    values[4, 4, 4] = value
    d = Deformation([[0, 0, 0]], [[0, 0, 0]], device=device)
    steps = np.array(list(product((-3, 0, 0.25, 0.5), repeat=3)))
    for step in steps:
        target = Grid((1, 1, 1), 4 + step)
        (got,) = d.resample([values], Sampling(grid, target, interpolation))
        np.testing.assert_array_equal(got.item(), value if (step >= 0).all() else 1.0)


def test_values_whose_difference_is_infinite(device):
    grid, target = Grid((2, 1, 1)), Grid((1, 1, 1), (0.5, 0, 0))
    most = np.finfo(float).max
    d = Deformation([[0, 0, 0]], [[0, 0, 0]], device=device)
    for pair, expected in (((most, -most), 0), ((most, most), most)):
        (got,) = d.resample([np.array(pair).reshape(grid.shape)], Sampling(grid, target))
        assert got.item() == expected


@pytest.mark.parametrize("dtype", DTYPES[:8])
def test_halves_are_rounded_to_even(device, dtype):
    """For odd and even values alike."""
    grid, target = Grid((5, 1, 1)), Grid((4, 1, 1), (0.5, 0, 0))
    values = np.array([0, 1, 2, 3, 2]).astype(dtype).reshape(grid.shape)
    d = Deformation([[0, 0, 0]], [[0, 0, 0]], device=device)
    (got,) = d.resample([values], Sampling(grid, target))
    assert got.ravel().tolist() == [0, 2, 2, 2]


@pytest.mark.parametrize("dtype", DTYPES[:8])
def test_overshoot_ends_where_the_type_does(device, dtype):
    low, high = int(np.iinfo(dtype).min), int(np.iinfo(dtype).max)
    grid, target = Grid((6, 1, 1)), Grid((1, 1, 1), (2.5, 0, 0))
    d = Deformation([[0, 0, 0]], [[0, 0, 0]], device=device)
    for inner, outer in ((high, low), (low, high)):
        values = np.array([outer, outer, inner, inner, outer, outer], dtype).reshape(grid.shape)
        (got,) = d.resample([values], Sampling(grid, target, "cubic"))
        assert got.item() == inner


@pytest.mark.parametrize(("base", "step"), [(123456789, 1), (4_500_000.25, 0.3), (2**52, 3)])
def test_the_gradient_at_a_cut_is_that_of_the_step(device, base, step):
    """Between a constant and the void, however large the values are."""
    grid = Grid((12, 12, 12))
    rest = np.array([(3, 3, 3), (9, 9, 9), (3, 9, 5), (9, 3, 7), (9, 9, 3.0)])
    moves = np.where(rest[:, 2:] < 6, -1, 1) * [[0, 0, 1]]
    cut = HalfPlane((6, 6, 6), (0, 0, 1), (1, 0, 0))
    d = Deformation(rest, rest + moves, cuts=cut, device=device)
    got, expected = (
        d.corrected_gradient(np.full(grid.shape, value), Sampling(grid, background=background))
        for value, background in ((base + step, base), (step, 0))
    )
    assert np.abs(expected).max() > step / 2
    np.testing.assert_allclose(got, expected, atol=8 * np.finfo(float).eps * base)


def test_gradient_at_a_cut_of_a_view(device, rng):
    """One component of an array."""
    grid = Grid((6, 6, 6))
    components = rng.normal(size=(*grid.shape, 2)).astype(np.float32)
    cut = HalfPlane((3, 3, 3), (0, 0, 1), (1, 0, 0))
    d = Deformation([[1, 1, 1], [4, 4, 4]], [[1, 1, 0], [4, 4, 5]], cuts=cut, device=device)
    one = components[..., 0]
    np.testing.assert_array_equal(
        d.corrected_gradient(one, grid), d.corrected_gradient(one.copy(), grid)
    )


def test_each_array_has_its_own_interpolation(device):
    grid, target = Grid((2, 1, 1)), Grid((1, 1, 1), origin=(0.25, 0, 0))
    values = np.array([0.0, 8.0]).reshape(grid.shape)
    d = Deformation([[0, 0, 0]], [[0, 0, 0]], device=device)
    near, linear = d.resample([values, values], Sampling(grid, target, ["nearest", "linear"]))
    assert (near.item(), linear.item()) == (0, 2)


@pytest.mark.parametrize(
    ("kind", "device"),
    [
        ("rigid", "reference"),  # which takes its time
        *product(["affine", "rigid", "similarity", "polynomial"], DEVICES),
    ],
)
def test_fitted_grid_holds_the_whole_volume(device, kind, rng):
    """No place outside of the fitted grid has its origin in the volume."""
    source = oriented_grid(rng, (40, 30, 20))
    rest, deformed = handles_in(source, rng, 12, 4)
    d = Deformation(rest, deformed, kind, device=device)
    fitted = d.fitted_grid(source)
    np.testing.assert_array_equal(fitted.spacing, source.spacing)
    first = source.index_of(fitted.origin[None])[0]
    np.testing.assert_allclose(first, np.rint(first), atol=1e-9)
    around = Grid(
        np.array(fitted.dimensions) + 20,
        fitted.at([[-10, -10, -10]])[0],
        source.spacing,
        source.direction,
    )
    ones = np.ones(source.shape, np.uint8)
    held = d.resample([ones], Sampling(source, fitted, "nearest"))[0].sum()
    whole = d.resample([ones], Sampling(source, around, "nearest"))[0].sum()
    if kind == "polynomial":  # copies from far away can be thinner than the samples of the box
        assert held >= 0.998 * whole
    else:
        assert held == whole
        assert fitted.size < 10 * source.size


def test_fitted_grid_of_a_slice_is_a_slice(device):
    source = Grid((20, 15, 1))
    d = Deformation([[5, 5, 0], [15, 10, 0]], [[8, 5, 0], [19, 14, 0]], device=device)
    assert d.fitted_grid(source).dimensions[2] == 1


def test_fitted_grid_follows_a_far_move(device):
    source = Grid((10, 10, 10))
    d = Deformation([[5, 5, 5]], [[1005, 5, 5]], device=device)
    fitted = d.fitted_grid(source)
    got = d.resample([np.ones(source.shape)], Sampling(source, fitted))[0]
    assert got.sum() == pytest.approx(1000)


def test_more_values_than_31_bits_count(key):
    """Memory that nothing is written to costs none."""
    grid = Grid((2**16, 2**15 + 1, 1))
    image = np.zeros(grid.shape, np.uint8)
    image[0, -1, -3:] = 5, 6, 7
    corner = Grid((3, 1, 1), (2**16 - 3, 2**15, 0))
    d = Deformation([[0, 0, 0]], [[0, 0, 0]], device=key)
    assert d.resample([image], Sampling(grid, corner))[0].tolist() == [[[5, 6, 7]]]


@pytest.mark.parametrize("dtype", [">i2", ">f4", ">f8"])
def test_arrays_of_the_other_byte_order(dtype, device, rng):
    """As nibabel and numpy read them from files."""
    grid = Grid((9, 8, 7))
    values = rng.integers(-300, 300, grid.shape)
    d = Deformation([(0, 0, 0)], [(0.5, 0, 0)], device=device)
    (expected,) = d.resample([values.astype(np.dtype(dtype).newbyteorder("="))], grid)
    (got,) = d.resample([values.astype(dtype)], grid)
    assert got.dtype == dtype
    np.testing.assert_array_equal(got, expected)
