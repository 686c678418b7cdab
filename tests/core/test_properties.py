"""What every backward map must do, asked of the specification and of each device."""

import numpy as np
import pytest
from control_point_sets import (
    DEVICES,
    EXTENT,
    HARD_SETS,
    KINDS_AND_DEGREES,
    TOLERANCE,
    deformation,
    places,
    random_handles,
    random_rotation,
    slopes,
)
from pairwise import paired, rare

from vtk_mls import Deformation
from vtk_mls.model.kinds.polynomials import monomial_values

# Share of the extent that float64 arithmetic, or float32 kernels, may lose.
PRECISION = {"reference": 1e-10} | {device: 2e-6 for device in DEVICES}


def some_places(rng, deformed):
    """Of all sorts, and fewer where each takes long."""
    v = places(rng, deformed, 50)[:200]
    return v if len(deformed) < 1000 else v[::4]


def size_of(points):
    return np.ptp(points, axis=0).max()


@paired(
    name=HARD_SETS,
    kind_and_degree=KINDS_AND_DEGREES,
    alpha=[2, 1, 0.5, 3, *rare(1.3, 2.2)],
    device=PRECISION,
)
def test_is_finite_and_interpolates_the_control_points(name, kind_and_degree, alpha, device, rng):
    rest, deformed = HARD_SETS[name](rng)
    d = deformation(rest, deformed, kind_and_degree, device, alpha=alpha)
    v = some_places(rng, deformed)
    assert np.isfinite(d.backward(v)).all()
    assert np.isfinite(d.jacobian(v)).all()
    count = 300 if len(rest) < 1000 else 60  # each takes longer
    # one place cannot have two origins: coincident control points count as one
    rest, deformed = (
        d.regions[0].control_points.handles.rest[:count],
        d.regions[0].control_points.handles.deformed[:count],
    )
    error = np.abs(d.backward(deformed) - rest).max()
    reach = max(size_of(d.rest), size_of(d.deformed), 1e-6 * np.abs(d.rest).max())
    assert error <= PRECISION[device] * reach


@paired(name=HARD_SETS, kind_and_degree=KINDS_AND_DEGREES, device=PRECISION)
def test_is_the_identity_where_nothing_moved(name, kind_and_degree, device, rng):
    _, deformed = HARD_SETS[name](rng)
    d = deformation(deformed, deformed, kind_and_degree, device)
    v = places(rng, deformed, 100)
    np.testing.assert_array_equal(d.backward(v), v)
    np.testing.assert_array_equal(d.jacobian(v), np.broadcast_to(np.eye(3), (len(v), 3, 3)))
    field = d.displacement_field((5, 4, 3), deformed[0], np.full(3, size_of(deformed) / 9 + 1e-30))
    np.testing.assert_array_equal(field.displacement, 0)


def test_is_a_translation_where_all_move_alike(kind_and_degree, device, rng):
    _, deformed = random_handles(rng, 9)
    d = deformation(deformed + [1, -2, 0.5], deformed, kind_and_degree, device)
    v = places(rng, deformed)
    np.testing.assert_allclose(d.backward(v), v + [1, -2, 0.5], rtol=0, atol=1e-9)


def own_map(kind, degree, rng):
    """A random map of the kind, as a function on points around the center of the cube."""
    rotation = random_rotation(rng)
    if kind == "rigid":
        return lambda v: (v - 128) @ rotation.T + 120
    if kind == "similarity":
        return lambda v: 0.8 * (v - 128) @ rotation.T + 140
    if kind == "affine":
        matrix = rotation + rng.normal(0, 0.2, (3, 3))
        return lambda v: (v - 128) @ matrix.T + 120
    if kind != "polynomial":  # every kind has the translations
        return lambda v: v + [3, -8, 5]
    count = {1: 3, 2: 9, 3: 19}[degree]
    coefficients = rng.normal(0, 0.3, (count, 3))
    return lambda v: 128 + 128 * monomial_values((v - 128) / 128, degree) @ coefficients


def test_reproduces_its_own_maps(kind_and_degree, device, rng):
    kind, degree = kind_and_degree
    own = own_map(kind, degree, rng)
    deformed = rng.uniform(0, EXTENT, (40, 3))
    d = deformation(own(deformed), deformed, kind_and_degree, device)
    v = rng.uniform(0, EXTENT, (500, 3))
    expected = own(v)
    tolerance = PRECISION[device] * size_of(expected) * (10 if kind == "polynomial" else 1)
    np.testing.assert_allclose(d.backward(v), expected, rtol=0, atol=tolerance)


def test_does_not_depend_on_the_order_of_control_points(kind_and_degree, device, rng):
    rest, deformed = random_handles(rng, 25)
    order = rng.permutation(25)
    v = places(rng, deformed)
    one = deformation(rest, deformed, kind_and_degree, device).backward(v)
    other = deformation(rest[order], deformed[order], kind_and_degree, device).backward(v)
    np.testing.assert_allclose(one, other, rtol=0, atol=10 * PRECISION[device] * EXTENT)


@paired(kind_and_degree=KINDS_AND_DEGREES, count=[2, 3, 7, 25], device=PRECISION)
def test_moves_and_scales_with_everything(kind_and_degree, device, count, rng):
    """Same answer in a frame that is turned, scaled and moved, also for degenerate sets."""
    rest, deformed = random_handles(rng, count)
    rotation, factor, offset = random_rotation(rng), 3.7, np.array([400, -300, 50])

    def frame(points):
        return factor * points @ rotation.T + offset

    v = places(rng, deformed)
    one = frame(deformation(rest, deformed, kind_and_degree, device).backward(v))
    other = deformation(frame(rest), frame(deformed), kind_and_degree, device).backward(frame(v))
    reach = max(size_of(one), factor * EXTENT)
    np.testing.assert_allclose(one, other, rtol=0, atol=20 * PRECISION[device] * reach)


def test_weights_count_as_repeated_control_points(kind_and_degree, device, rng):
    rest, deformed = random_handles(rng, 12)
    weights = rng.integers(1, 4, 12)
    v = places(rng, deformed)
    one = deformation(rest, deformed, kind_and_degree, device, weights=weights)
    repeated = np.repeat(np.arange(12), weights)
    other = deformation(rest[repeated], deformed[repeated], kind_and_degree, device)
    np.testing.assert_allclose(
        one.backward(v), other.backward(v), rtol=0, atol=20 * PRECISION[device] * EXTENT
    )


def test_coincident_control_points_count_as_their_mean(kind_and_degree, device, rng):
    rest, deformed = random_handles(rng, 8)
    deformed[5] = deformed[4]
    d = deformation(rest, deformed, kind_and_degree, device, weights=[1, 1, 1, 1, 3, 1, 1, 1])
    expected = (3 * rest[4] + rest[5]) / 4
    got = d.backward(deformed[4:5])[0]
    np.testing.assert_allclose(got, expected, rtol=0, atol=10 * PRECISION[device] * EXTENT)


def test_control_points_all_in_one_position_count_as_their_mean(kind_and_degree, device):
    rest, deformed = [[0, 0, 0], [4, 0, 8]], [[1, 1, 1], [1, 1, 1]]
    d = deformation(rest, deformed, kind_and_degree, device, weights=[3, 1])
    np.testing.assert_allclose(d.backward([[1, 1, 1], [5, 5, 5]]), [[1, 0, 2], [5, 4, 6]])


@pytest.mark.parametrize("name", HARD_SETS)
def test_degree_1_is_affine(name, device, rng):
    rest, deformed = HARD_SETS[name](rng)
    v = some_places(rng, deformed)
    affine, polynomial = (
        deformation(rest, deformed, kind_and_degree, device, alpha=1.3)
        for kind_and_degree in (("affine", 1), ("polynomial", 1))
    )
    np.testing.assert_array_equal(polynomial.backward(v), affine.backward(v))
    np.testing.assert_array_equal(polynomial.jacobian(v), affine.jacobian(v))


def test_a_line_turns_without_twist(device):
    """Two control points turned by 90 degrees about z: z itself stays."""
    for kind in ("rigid", "similarity"):
        d = deformation([[0, 0, 0], [0, 2, 0]], [[0, 0, 0], [2, 0, 0]], (kind, 1), device)
        got = d.backward([[1, 0, 0], [0, 0, 1], [0, 1, 0]])
        expected = [[0, 1, 0], [0, 0, 1], [-1, 0, 0]]
        np.testing.assert_allclose(got, expected, rtol=0, atol=1e-5)


def test_a_plane_keeps_what_is_across_it(device):
    """Affine and polynomial maps of a flat set leave the direction across it alone."""
    xy = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [4, 4, 0], [2, 1, 0], [1, 3, 0]], float)
    for kind in (("affine", 1), ("polynomial", 1)):
        d = deformation(xy * [1.5, 1, 1], xy, kind, device)
        np.testing.assert_allclose(d.backward([[1, 1, 3]]), [[1.5, 1, 3]], rtol=0, atol=1e-5)


def test_a_set_that_rounding_makes_thick_is_flat(device, rng):
    """What is across it would have slopes as large as displacement over thickness."""
    flat = rng.uniform(0, EXTENT, (12, 3)) * [1, 1, 0]
    rest = flat + rng.normal(0, 4, flat.shape)
    thick = flat + [0, 0, 1e-7 * EXTENT] * rng.normal(size=flat.shape)
    v = places(rng, flat + [0, 0, 1], 50)
    for kind in (("affine", 1), ("polynomial", 2), ("polynomial", 3)):
        got, expected = (deformation(rest, q, kind, device).backward(v) for q in (thick, flat))
        np.testing.assert_allclose(got, expected, rtol=0, atol=1e-3 * EXTENT)


@pytest.mark.parametrize("kind", ["rigid", "similarity"])
def test_a_narrow_set_turns_about_its_length(kind, device, rng):
    deformed = rng.uniform(-1, 1, (12, 3)) * [100, 1, 1]
    half_turn = np.array([1, -1, -1])
    v = rng.uniform(-1, 1, (20, 3)) * [100, 5, 5]
    got = deformation(deformed * half_turn, deformed, (kind, 1), device).backward(v)
    np.testing.assert_allclose(got, v * half_turn, rtol=0, atol=1e-3)


def test_jacobian_is_the_derivative(kind_and_degree, rng):
    """The specification's closed form against differences of the specification's map."""
    for count in (1, 2, 3, 4, 7, 15, 40):
        for alpha, smoothing in ((1, 0), (1.3, 0), (2, 0), (1, 1), (2, 30)):
            rest, deformed = random_handles(rng, count)
            options = {"alpha": alpha, "smoothing": smoothing}
            d = deformation(rest, deformed, kind_and_degree, **options)
            v = rng.uniform(0, EXTENT, (50, 3))
            got, expected = d.jacobian(v), slopes(d, v, 1e-3)
            assert np.abs(got - expected).max() <= 1e-5 * max(1, np.abs(expected).max())


def test_jacobian_at_a_control_point_is_the_limit(kind_and_degree, device, rng):
    rest, deformed = random_handles(rng, 15)
    d = deformation(rest, deformed, kind_and_degree, device)
    near = d.jacobian(deformed + 1e-4)
    np.testing.assert_allclose(d.jacobian(deformed), near, rtol=0, atol=2e-3)


def fitted(rest, deformed, v, kind, alpha, smoothing):
    """G(v) by the equations of the paper, for one v (3,): Eq. 3 to 7, and Kabsch's rotation."""
    w = 1 / (((deformed - v) ** 2).sum(axis=1) + smoothing**2) ** alpha
    p_star, q_star = w @ rest / w.sum(), w @ deformed / w.sum()
    p, q = rest - p_star, w[:, None] * (deformed - q_star)
    if kind == "affine":
        m = np.linalg.solve(q.T @ (deformed - q_star), q.T @ p)
    else:
        u, _, vt = np.linalg.svd(q.T @ p)
        m = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return (v - q_star) @ m + p_star


@paired(
    kind=["rigid", "affine"], alpha=[2, 1.3, *rare(1, 3)], smoothing=[0, 2, 40], device=PRECISION
)
def test_is_the_fit_with_these_weights(kind, alpha, smoothing, device, rng):
    rest, deformed = random_handles(rng, 15)
    d = Deformation(rest, deformed, kind, alpha=alpha, smoothing=smoothing, device=device)
    v = np.concatenate([rng.uniform(0, EXTENT, (50, 3)), deformed + 0.1])
    expected = [fitted(rest, deformed, place, kind, alpha, smoothing) for place in v]
    bound = 1e-9 if device == "reference" else TOLERANCE[kind, 1][0]
    assert np.linalg.norm(d.backward(v) - expected, axis=1).max() <= bound
