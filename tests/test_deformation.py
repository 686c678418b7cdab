"""The value: validation, immutability, and the questions' arguments."""

import dataclasses

import numpy as np
import pytest
from conftest import DEVICES, random_handles

import vtk_mls
from vtk_mls import Aborted, Deformation, Grid

GOOD = {"rest": np.eye(3), "deformed": np.eye(3) + 1, "device": "reference"}


@pytest.mark.parametrize(
    ("bad", "error", "message"),
    [
        ({"rest": [], "deformed": []}, ValueError, "`rest` is empty.*at least one control point"),
        ({"rest": np.eye(3)[:2]}, ValueError, "same number of control points, got 2 and 3"),
        ({"rest": np.zeros((3, 2))}, ValueError, r"`rest` must have the shape \(n, 3\)"),
        ({"deformed": np.full((3, 3), np.nan)}, ValueError, "`deformed` must be finite.*row 0"),
        ({"rest": np.full((3, 3), np.inf)}, ValueError, "`rest` must be finite"),
        ({"rest": [["a"] * 3] * 3}, TypeError, "`rest` must be numbers"),
        ({"kind": "rigit"}, ValueError, "`kind` must be one of affine, rigid.*'rigit'"),
        ({"degree": 0}, ValueError, "`degree` must be 1, 2 or 3, got 0"),
        ({"degree": 1.5}, ValueError, "`degree` must be 1, 2 or 3"),
        ({"alpha": 0}, ValueError, "`alpha` must be a positive number, got 0"),
        ({"alpha": -1}, ValueError, "`alpha` must be a positive number"),
        ({"alpha": np.nan}, ValueError, "`alpha` must be a positive number"),
        ({"alpha": "one"}, TypeError, "`alpha` must be a number, got 'one'"),
        ({"weights": [1, 2]}, ValueError, r"`weights` must be one number per control point"),
        ({"weights": [1, 0, 1]}, ValueError, "`weights` must be positive, got 0.0.*point 1"),
        ({"weights": [1, 1, -2]}, ValueError, "`weights` must be positive, got -2.0"),
        ({"weights": [1, np.nan, 1]}, ValueError, "`weights` must be positive"),
        ({"weights": ["x", 1, 1]}, TypeError, "`weights` must be numbers"),
    ],
)
def test_bad_arguments_are_named(bad, error, message):
    with pytest.raises(error, match=message):
        Deformation(**{**GOOD, **bad})


def test_is_immutable_and_keeps_no_link_to_its_input():
    rest = np.eye(3)
    d = Deformation(rest, rest + 1, device="reference")
    rest[0] = 99
    assert d.rest[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        d.rest[0] = 5
    with pytest.raises(dataclasses.FrozenInstanceError, match="alpha"):
        d.alpha = 2


def test_says_what_it_is():
    assert repr(Deformation(**GOOD)) == "<Deformation rigid, alpha=1, 3 control points>"
    polynomial = Deformation(**GOOD, kind="polynomial", alpha=1.5)
    assert repr(polynomial) == "<Deformation polynomial, degree=2, alpha=1.5, 3 control points>"


def test_needs_neither_vtk_nor_opencl_to_import():
    import subprocess
    import sys

    code = "import sys; sys.modules['pyopencl'] = sys.modules['vtkmodules'] = None; import vtk_mls"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("device", ["reference", *DEVICES])
def test_no_points_give_no_points(device):
    d = Deformation(np.eye(3), np.eye(3) + 1, device=device)
    assert d.backward([]).shape == (0, 3)
    assert d.jacobian(np.empty((0, 3))).shape == (0, 3, 3)


def test_points_are_checked():
    d = Deformation(**GOOD)
    with pytest.raises(ValueError, match=r"`points` must have the shape \(n, 3\), got \(3,\)"):
        d.backward([1, 2, 3])
    with pytest.raises(ValueError, match="`points` must be finite"):
        d.backward([[1, 2, np.nan]])


def test_resample_arguments_are_checked():
    d, grid = Deformation(**GOOD), Grid((4, 3, 2))
    with pytest.raises(ValueError, match=r"`arrays` must have the shape of the grid, \(2, 3, 4\)"):
        d.resample([np.zeros((4, 3, 2))], grid)
    with pytest.raises(TypeError, match="`arrays` must hold integers or floats, got complex"):
        d.resample([np.zeros(grid.shape, complex)], grid)
    with pytest.raises(ValueError, match="`interpolation` must be one of nearest, linear, cubic"):
        d.resample([np.zeros(grid.shape)], grid, interpolation="quintic")
    with pytest.raises(ValueError, match=r"`interpolation` must be .* one for each"):
        d.resample([np.zeros(grid.shape)], grid, interpolation=["linear", "cubic"])


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ({"dimensions": (4, 0, 3)}, "`dimensions` must be three positive integers"),
        ({"dimensions": (4, 4)}, "`dimensions` must be three positive integers"),
        ({"origin": (0, 0)}, "`origin` must be"),
        ({"spacing": (1, 0, 1)}, "`spacing` must not be zero"),
        ({"direction": np.zeros((3, 3))}, "`direction` must be invertible"),
    ],
)
def test_grids_are_checked(bad, message):
    with pytest.raises(ValueError, match=message):
        Grid(**{"dimensions": (4, 4, 4), **bad})


@pytest.mark.parametrize("device", ["reference", *DEVICES])
def test_progress_can_stop_the_work(device, rng):
    d = Deformation(*random_handles(rng, 2000), device=device)
    seen = []

    def stop_at_once(fraction):
        seen.append(fraction)
        return True

    grid = Grid((300, 200, 10))
    for work in (
        lambda: d.displacement_field(grid.dimensions, progress=stop_at_once),
        lambda: d.resample([np.zeros(grid.shape)], grid, progress=stop_at_once),
        lambda: d.backward(np.ones((400_000, 3)), progress=stop_at_once),
    ):
        seen.clear()
        with pytest.raises(Aborted, match="as `progress` asked"):
            work()
        assert len(seen) == 1
        assert 0 < seen[0] < 1
    assert d.backward([[1, 2, 3]]).shape == (1, 3)  # and it works again


def test_public_names():
    assert vtk_mls.KINDS == ("affine", "rigid", "similarity", "polynomial")
    for name in vtk_mls.__all__:
        assert getattr(vtk_mls, name).__doc__
