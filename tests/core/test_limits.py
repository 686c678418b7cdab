"""Masks and faces: where a deformation acts."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import DEVICES, EVERYWHERE, KINDS_AND_DEGREES, deformation
from map_checks import check_inverse, check_jacobian, check_kernels
from pairwise import paired, rare

from vtk_mls import (
    BallMask,
    BoxMask,
    FixedFace,
    Grid,
    HalfPlane,
    ImageMask,
    Plane,
    Sampling,
    SlidingFace,
    Surface,
)

GRID = Grid((24, 22, 20), (-1, -1, -1), (2 / 23, 2 / 21, 2 / 19))
SQUARE = Surface(
    [(-1, -1, -0.6), (1, -1, -0.6), (1, 1, -0.6), (-1, 1, -0.6)], [(0, 1, 2), (0, 2, 3)]
)


def image_mask():
    """A mask that is 1 in the middle and 0 at the border of its grid."""
    grid = Grid((20, 20, 20), (-0.8, -0.8, -0.8), (1.6 / 19,) * 3)
    distance = np.abs(grid.points()).max(axis=1).reshape(grid.shape)
    return ImageMask(np.clip(2 - 3 * distance, 0, 1), grid)


LIMITS = {
    "ball": lambda: {"mask": BallMask((0.1, 0, 0), 0.3, 0.4)},
    "box": lambda: {"mask": BoxMask((-0.5, -0.4, -0.3), (0.3, 0.4, 0.5), 0.4)},
    "image": lambda: {"mask": image_mask()},
    "fixed plane": lambda: {"constraints": FixedFace(Plane((0, 0, -0.6), (0, 0.2, 1)), 0.8)},
    "sliding plane": lambda: {"constraints": SlidingFace(Plane((0, 0, -0.6), (0, 0.2, 1)), 0.8)},
    "fixed surface": functools.cache(lambda: {"constraints": [FixedFace(SQUARE, 0.8)]}),
    "sliding surface": functools.cache(lambda: {"constraints": [SlidingFace(SQUARE, 0.8)]}),
    "several": lambda: {
        "mask": BallMask((0.1, 0, 0), 0.8, 0.4),
        "constraints": [
            FixedFace(Plane((0, 0, -0.6), (0, 0, 1)), 0.5),
            SlidingFace(Plane((0.8, 0, 0), (1, 0, 0)), 0.5),
        ],
    },
}
HALF_PLANE = HalfPlane((0, 0, 0.1), (0.2, 0.1, 1), (1, 0.3, 0))
CUTS = {
    "none": {},
    "moving": {"cuts": HALF_PLANE, "cut_frame": "rest"},
    "staying": {"cuts": HALF_PLANE, "cut_frame": "deformed"},
}


def scene(rng, kind=("rigid", 1), device="reference", count=12, **options):
    rest = rng.uniform(-0.9, 0.9, (count, 3))
    deformed = rest + rng.normal(0, 0.08, rest.shape)
    return deformation(rest, deformed, kind, device, **options)


@paired(
    limit=LIMITS,
    kind=[*KINDS_AND_DEGREES[:2], *rare(*KINDS_AND_DEGREES[2:])],
    cuts=["none", "moving", *rare("staying")],
    device=DEVICES,
)
def test_kernels_agree_with_the_specification(limit, kind, cuts, device, rng):
    specification = scene(rng, kind, count=25, **LIMITS[limit](), **CUTS[cuts])
    kernels = replace(specification, device=device)
    check_kernels(kernels, specification, rng.uniform(-1, 1, (2000, 3)), kind[1], 2e-4)


@paired(limit=LIMITS, kind=KINDS_AND_DEGREES, cuts=CUTS)
def test_jacobian_is_the_slope(limit, kind, cuts, rng):
    d = scene(rng, kind, count=25, **LIMITS[limit](), **CUTS[cuts])
    check_jacobian(d, rng.uniform(-1, 1, (100, 3)))


@paired(
    limit=LIMITS,
    kind=[("rigid", 1), *rare(*KINDS_AND_DEGREES[1:4])],
    cuts=["none", *rare("moving", "staying")],
    device=EVERYWHERE,
)
def test_forward_undoes_backward(limit, kind, cuts, device, rng):
    d = scene(rng, kind, device, 25, **LIMITS[limit](), **CUTS[cuts])
    v = rng.uniform(-1, 1, (60, 3))
    check_inverse(d, v[np.linalg.det(d.jacobian(v)) > 0.2])  # where the map does not fold


@paired(
    mask=["ball", "box", "image"],
    kind=[("rigid", 1), *rare(*KINDS_AND_DEGREES[1:])],
    device=EVERYWHERE,
)
@pytest.mark.parametrize("interpolation", ["linear", "cubic", "nearest"])
def test_outside_a_mask_is_the_input_to_the_bit(mask, kind, device, interpolation, rng):
    options = LIMITS[mask]()
    d = scene(rng, kind, device, 25, **options)
    outside = (options["mask"].factor(GRID.points())[0] == 0).reshape(GRID.shape)
    assert 0.1 < outside.mean() < 0.95
    values = rng.random(GRID.shape).astype(np.float32)
    values[0, 0, 0] = np.nan
    (result,) = d.resample([values], Sampling(GRID, interpolation=interpolation))
    np.testing.assert_array_equal(result[outside], values[outside])
    if interpolation != "nearest":
        assert (result[~outside] != values[~outside]).mean() > 0.5
    assert (d.displacement_field(GRID).displacement[outside] == 0).all()
    x = GRID.points()[outside.ravel()][:500]
    np.testing.assert_array_equal(d.forward(x), x)
    np.testing.assert_array_equal(d.backward(x), x)


@pytest.mark.matrix
def test_outside_a_mask_is_the_input_within_a_tolerance_too(key, rng):
    grid = Grid((96, 96, 96), (-1, -1, -1), (2 / 95,) * 3)
    mask = BallMask((0.1, 0, 0), 0.3, 0.4)
    exact = scene(rng, device=key, mask=mask)
    coarse = replace(exact, map_tolerance=0.02)
    outside = np.linalg.norm(grid.points() - mask.center, axis=1).reshape(grid.shape) >= 0.7
    values = rng.random(grid.shape).astype(np.float32)
    (result,) = coarse.resample([values], Sampling(grid))
    np.testing.assert_array_equal(result[outside], values[outside])
    fields = [d.displacement_field(grid).displacement for d in (coarse, exact)]
    assert (fields[0][outside] == 0).all()
    error = np.abs(fields[0] - fields[1]).max()
    assert 0 < error < 0.02 * 2 / 95


def test_a_ball_mask_is_its_formula(device, rng):
    free = scene(rng, device=device)
    masked = replace(free, mask=BallMask((0.1, 0, 0), 0.3, 0.4))
    v = rng.uniform(-1, 1, (2000, 3))
    t = np.clip((np.linalg.norm(v - (0.1, 0, 0), axis=1) - 0.3) / 0.4, 0, 1)
    share = 1 - (6 * t**5 - 15 * t**4 + 10 * t**3)
    expected = v + share[:, None] * (free.backward(v) - v)
    np.testing.assert_allclose(masked.backward(v), expected, atol=2e-6)


@pytest.mark.parametrize("face", [Plane((0, 0, -0.6), (0, 0, 1)), SQUARE], ids=["plane", "surface"])
def test_faces_stay_or_slide(face, device, rng):
    on_face = np.column_stack([rng.uniform(-0.9, 0.9, (200, 2)), np.full(200, -0.6)])
    free = scene(rng, device=device)
    fixed = replace(free, constraints=FixedFace(face, 0.5))
    np.testing.assert_array_equal(fixed.backward(on_face), on_face)
    sliding = replace(free, constraints=SlidingFace(face, 0.5))
    moved = sliding.backward(on_face) - on_face
    np.testing.assert_allclose(moved[:, 2], 0, atol=1e-6)
    assert np.abs(moved[:, :2]).max() > 0.01
    beyond = rng.uniform(-0.9, 0.9, (200, 3)) * (1, 1, 0.4) + (0, 0, 0.4)
    np.testing.assert_allclose(fixed.backward(beyond), free.backward(beyond), atol=2e-6)


def test_handles_in_a_fall_off_are_not_met(rng):
    d = scene(rng, mask=BallMask((0.1, 0, 0), 0.3, 0.4))
    distance = np.linalg.norm(d.deformed - (0.1, 0, 0), axis=1)
    missed = np.linalg.norm(d.residuals(), axis=1) > 1e-9
    np.testing.assert_array_equal(missed, distance > 0.3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: BallMask((0, 0, 0), 0, 1), "`radius` must be a positive number, got 0"),
        (lambda: BallMask((0, 0, 0), 1, 0), "`falloff` must be a positive number, got 0"),
        (lambda: BoxMask((0, 0, 1), (1, 1, 0), 1), "`high` must not be below `low`"),
        (
            lambda: ImageMask(np.ones((2, 2, 2)), Grid((3, 2, 2))),
            r"`values` must have the shape \(2, 2, 3\) of `grid`, got \(2, 2, 2\)",
        ),
        (lambda: ImageMask(np.full((2, 2, 2), 2), Grid((2, 2, 2))), "`values` must be from 0 to 1"),
        (
            lambda: ImageMask(np.full((2, 2, 2), np.nan), Grid((2, 2, 2))),
            "`values` must be from 0 to 1",
        ),
        (lambda: FixedFace((0, 0, 1), 1), "`face` must be a Plane or a Surface"),
        (lambda: SlidingFace(Plane((0, 0, 0), (0, 0, 1)), -1), "`falloff` must be a positive"),
        (lambda: scene(np.random.default_rng(), mask=1), "`mask` must be a BallMask"),
        (lambda: scene(np.random.default_rng(), constraints=1), "`constraints` must be FixedFace"),
    ],
)
def test_bad_arguments_are_refused(make, message):
    with pytest.raises((TypeError, ValueError), match=message):
        make()
