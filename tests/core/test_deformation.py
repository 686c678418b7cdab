"""The value: validation, immutability, and the questions' arguments."""

import dataclasses

import numpy as np
import pytest

import vtk_mls
from vtk_mls import Deformation, Grid, HalfPlane, Plane, Sampling, Surface

FAR_CUTS = (
    Plane((0, 0, 1e20), (0, 0, 1)),
    HalfPlane((1e20, 0, 0), (0, 0, 1), (1, 0, 0)),
    Surface.polygon([(0, 0, 0), (1e20, 0, 0), (0, 1e20, 0)]),
)
SEVEN_PLANES = [Plane((0, 0, i), (0, 0, 1)) for i in range(7)]
GOOD = {"rest": np.eye(3), "deformed": np.eye(3) + 1, "device": "reference"}


@pytest.mark.parametrize(
    ("bad", "error", "message"),
    [
        ({"rest": [], "deformed": []}, ValueError, "`rest` is empty.*at least one control point"),
        ({"rest": np.eye(3)[:2]}, ValueError, "same number of control points, got 2 and 3"),
        ({"rest": np.zeros((3, 2))}, ValueError, r"`rest` must have the shape \(n, 3\)"),
        ({"deformed": np.full((3, 3), np.nan)}, ValueError, "`deformed` must be finite.*row 0"),
        ({"rest": np.full((3, 3), np.inf)}, ValueError, "`rest` must be finite"),
        ({"rest": [(0, 0, 0), (0, 1e299, 0)]}, ValueError, "`rest` must be within 1e.37.* row 1"),
        (
            {"deformed": [(0, 0, 0), (-1e38, 0, 0)]},
            ValueError,
            "`deformed` must be within .* row 1",
        ),
        ({"rest": [["a"] * 3] * 3}, TypeError, "`rest` must be numbers"),
        ({"kind": "rigit"}, ValueError, "`kind` must be one of affine, rigid.*'rigit'"),
        ({"cut_frame": "paper"}, ValueError, "`cut_frame` must be .*rest.*deformed.*'paper'"),
        ({"degree": 0}, ValueError, "`degree` must be 1, 2 or 3, got 0"),
        ({"degree": 1.5}, ValueError, "`degree` must be 1, 2 or 3"),
        ({"alpha": 0}, ValueError, "`alpha` must be a positive number, got 0"),
        ({"alpha": np.nan}, ValueError, "`alpha` must be a positive number"),
        ({"alpha": np.inf}, ValueError, "`alpha` must be a positive number, got inf"),
        ({"smoothing": np.nan}, ValueError, "`smoothing` must be a number from 0 on, got nan"),
        ({"smoothing": -1}, ValueError, "`smoothing` must be a number from 0 on, got -1"),
        ({"smoothing": "much"}, TypeError, "`smoothing` must be a number, got 'much'"),
        ({"smoothing": (1, 2)}, TypeError, r"`smoothing` must be a number, got \(1, 2\)"),
        *(
            ({"map_tolerance": bad}, ValueError, "`map_tolerance` must be a number from 0 on, got")
            for bad in (-0.1, np.nan, np.inf)
        ),
        ({"alpha": "one"}, TypeError, "`alpha` must be a number, got 'one'"),
        ({"weights": [1, 2]}, ValueError, r"`weights` must be one number per control point"),
        ({"weights": [1, 0, 1]}, ValueError, "`weights` must be positive, got 0.0.*point 1"),
        ({"weights": [1, 1, -2]}, ValueError, "`weights` must be positive, got -2.0"),
        ({"weights": [1, np.nan, 1]}, ValueError, "`weights` must be positive"),
        ({"weights": ["x", 1, 1]}, TypeError, "`weights` must be numbers"),
        ({"rest": np.eye(3) + 1j}, TypeError, "`rest` must be numbers of shape .* of complex128"),
        ({"deformed": [[1j, 0, 0]] * 3}, TypeError, "`deformed` must be numbers of shape"),
        ({"rest": [[1, 2, 3], [4, 5]]}, TypeError, "`rest` must be numbers of shape"),
        ({"rest": [[10**400, 2, 3]] * 3}, TypeError, "`rest` must be numbers of shape"),
        ({"weights": np.ones(3) + 1j}, TypeError, "`weights` must be numbers"),
        ({"alpha": 10**400}, TypeError, r"`alpha` must be a number, got 1000+\.\.\."),
        ({"alpha": 10**5000}, TypeError, "`alpha` must be a number, got an int"),
        ({"alpha": np.complex128(1 + 1j)}, TypeError, "`alpha` must be a number, got"),
        ({"alpha": np.ones(1000)}, TypeError, r"`alpha` must be a number.* shape \(1000,\)"),
        ({"nu": 10**400}, TypeError, "`nu` must be a number"),
        ({"nu": 1}, ValueError, "`nu` must be a number above 1, got 1"),
        ({"nu": np.nan}, ValueError, "`nu` must be a number above 1"),
        ({"kind": np.ones(1000)}, ValueError, r"`kind` must be one of.* shape \(1000,\)"),
        ({"kind": None}, ValueError, "`kind` must be one of.* got None"),
        ({"degree": np.ones(9)}, ValueError, r"`degree` must be 1, 2 or 3, got an array"),
        ({"cuts": 5}, TypeError, "`cuts` must be Plane, HalfPlane or Surface, got 5"),
        *(({"cuts": cut}, ValueError, "`cuts` must be within 1e.10 times the") for cut in FAR_CUTS),
        ({"cuts": SEVEN_PLANES}, ValueError, "`cuts` must have at most 6 planes, got 7"),
        *(
            ({"steps": bad}, (ValueError, TypeError), "`steps` must be")
            for bad in (-1, 257, 1.5, "many", None)
        ),
        *(
            ({"path": bad}, ValueError, "`path` must be finite numbers of shape")
            for bad in ([(0, 0, 0)], np.full((1, 3, 3), np.nan), np.zeros((1, 2, 3)))
        ),
        ({"cuts": [None]}, TypeError, "`cuts` must be Plane, HalfPlane or Surface, got None"),
        ({"cuts": np.ones((500, 3))}, TypeError, "`cuts` must be Plane, HalfPlane or Surface"),
    ],
)
def test_bad_arguments_are_named(bad, error, message):
    with pytest.raises(error, match=message) as raised:
        Deformation(**{**GOOD, **bad})
    assert len(str(raised.value)) < 200
    assert "\n" not in str(raised.value)


def test_no_cuts_can_be_given_in_several_ways():
    for cuts in (None, (), []):
        assert Deformation(**GOOD, cuts=cuts).cuts == ()


def test_nan_causes_no_warning_of_numpy(recwarn):
    places = np.array([(0, 0, 0), (1e300, 0, 0), (-1e200, 1e200, 5), (1e155, 1, 1)])
    cuts = [Plane((0, 0, 0.5), (0, 0, 1)), HalfPlane((0, 0, 0.2), (1, 0, 0), (0, 0, 1))]
    for kind in vtk_mls.KINDS:
        for some in ((), cuts):
            d = Deformation(**GOOD, kind=kind, cuts=some)
            for question in (d.backward, d.jacobian, d.void_distance, d.forward, d.forward_field):
                question(places)
            d.forward_field([(np.nan, 0, 0), (np.inf, 0, -np.inf), (0, 0, 0)])
    assert [str(warning.message) for warning in recwarn] == []


def test_is_immutable_and_keeps_no_link_to_its_input():
    rest = np.eye(3)
    d = Deformation(rest, rest + 1, device="reference")
    rest[0] = 99
    assert d.rest[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        d.rest[0] = 5
    with pytest.raises(dataclasses.FrozenInstanceError, match="alpha"):
        d.alpha = 2


def test_its_repr():
    assert repr(Deformation(**GOOD)) == "<Deformation rigid, alpha=2, 3 control points>"
    polynomial = Deformation(**GOOD, kind="polynomial", alpha=1.5)
    assert repr(polynomial) == "<Deformation polynomial, degree=2, alpha=1.5, 3 control points>"


def test_points_are_checked():
    d = Deformation(**GOOD)
    with pytest.raises(ValueError, match=r"`points` must have the shape \(n, 3\), got \(3,\)"):
        d.backward([1, 2, 3])
    with pytest.raises(ValueError, match="`points` must be finite"):
        d.backward([[1, 2, np.nan]])


def test_resample_arguments_are_checked():
    d, grid = Deformation(**GOOD), Grid((4, 3, 2))
    for shape in ((4, 3, 2), (2, 3, 4, 0)):
        with pytest.raises(ValueError, match=r"`arrays` must have the shape .* grid, \(2, 3, 4\)"):
            d.resample([np.zeros(shape)], grid)
    with pytest.raises(TypeError, match="`arrays` must hold integers or floats, got complex"):
        d.resample([np.zeros(grid.shape, complex)], grid)
    with pytest.raises(TypeError, match=r"`sampling` must be a Sampling or a Grid, got \(4, 3, 2"):
        d.resample([np.zeros(grid.shape)], (4, 3, 2))
    for question in (d.resample_gradients, d.resample_vectors):
        with pytest.raises(TypeError, match="`vectors` must be numbers"):
            question(np.zeros((*grid.shape, 3), complex), grid)
    with pytest.raises(ValueError, match=r"`vectors` must have .*\(2, 3, 4, 3\), got \(2, 3, 4\)"):
        d.resample_gradients(np.zeros(grid.shape), grid)
    with pytest.raises(ValueError, match="`array` must be real numbers .* of complex128"):
        d.corrected_gradient(np.zeros(grid.shape, complex), grid)
    with pytest.raises(ValueError, match=r"`interpolation` must be .* one for each"):
        d.resample([np.zeros(grid.shape)], Sampling(grid, interpolation=["linear", "cubic"]))
    for question in (d.void_field, d.void_distance_field, d.jacobian_field, d.fitted_grid):
        with pytest.raises(TypeError, match=r"must be a Grid, got \(4, 3, 2\)"):
            question((4, 3, 2))


@pytest.mark.parametrize(
    ("bad", "kind", "message"),
    [
        ({"source": (4, 3, 2)}, TypeError, r"`source` must be a Grid, got \(4, 3, 2\)"),
        ({"target": 5}, TypeError, "`target` must be a Grid, got 5"),
        (
            {"interpolation": "quintic"},
            ValueError,
            "`interpolation` must be one of nearest, linear",
        ),
        ({"interpolation": None}, ValueError, "`interpolation` must be one of nearest, linear"),
        ({"interpolation": ["linear", 3]}, ValueError, r"`interpolation` must be .*'linear', 3"),
        ({"background": "air"}, ValueError, "`background` must be a number or auto, or one"),
        ({"void_values": np.ones(99)}, ValueError, "`void_values` must be one of background, cont"),
    ],
)
def test_samplings_are_checked(bad, kind, message):
    with pytest.raises(kind, match=message):
        Sampling(**{"source": Grid((4, 3, 2)), **bad})


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ({"dimensions": (4, 0, 3)}, "`dimensions` must be three positive integers"),
        ({"dimensions": (4, 4)}, "`dimensions` must be three positive integers"),
        ({"dimensions": (4, 4, 2.5)}, "`dimensions` must be three positive integers"),
        ({"dimensions": np.ones((50, 50))}, "`dimensions` must be three .* shape"),
        ({"origin": np.ones((50, 50))}, r"`origin` must be .* shape \(50, 50\)"),
        ({"origin": (0, 0)}, "`origin` must be"),
        ({"spacing": (1, 0, 1)}, "`spacing` must not be zero"),
        ({"direction": np.zeros((3, 3))}, "`direction` must be invertible"),
    ],
)
def test_grids_are_checked(bad, message):
    with pytest.raises(ValueError, match=message):
        Grid(**{"dimensions": (4, 4, 4), **bad})


@pytest.mark.parametrize("length", [1e-200, 1e-5, 1e200])
def test_a_direction_may_have_any_length(length):
    np.testing.assert_allclose(Plane((0, 0, 0), (3 * length, 0, 4 * length)).normal, (0.6, 0, 0.8))


def test_public_names():
    assert vtk_mls.KINDS == ("affine", "rigid", "similarity", "polynomial")
    for name in vtk_mls.__all__:
        assert getattr(vtk_mls, name).__doc__
