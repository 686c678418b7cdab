"""What the report says about the volume around pairs: thin sets, mirrors, drags."""

import json

import numpy as np
import pytest
from control_point_sets import random_rotation, slopes
from landmark_pairs import planted_pairs, smooth_warp

from vtk_mls import Deformation
from vtk_mls.landmarks import report
from vtk_mls.landmarks.left_out import PointPairs
from vtk_mls.landmarks.text import heading
from vtk_mls.landmarks.volume import Shape

DEVICE = "reference"
Z = np.linspace(-160, 160, 18)


def _shape(p, q):
    return Shape.of(PointPairs(p, q, np.ones(len(p))))


def _spine(rng):
    p = np.c_[3 * np.sin(Z / 90), 12 * np.sin(Z / 110), Z]
    return p, p + np.c_[4 + 0 * Z, 6 * np.cos(Z / 100), 0.08 * Z] + rng.normal(0, 0.7, p.shape)


def _cord(rng):
    p = np.c_[0 * Z, 0 * Z, Z]
    return p, p + np.c_[4 + 0 * Z, 5 * np.cos(Z / 100), 0.08 * Z] + rng.normal(0, 0.7, p.shape)


def _slice(rng):
    p = np.c_[rng.uniform(-38, 38, (25, 2)), rng.normal(0, 0.3, 25)]
    wave = np.c_[3 * np.sin(p[:, 1] / 20), 2 * np.cos(p[:, 0] / 25)]
    return p, p + np.c_[wave, rng.normal(0, 0.3, 25)]


@pytest.mark.parametrize(("make", "name"), [(_spine, "line"), (_cord, "line"), (_slice, "plane")])
@pytest.mark.parametrize("turned", [False, True])
def test_maps_of_thin_sets_keep_the_volume_beside_them(make, name, turned):
    rng = np.random.default_rng(5)
    p, q = make(rng)
    matrix = random_rotation(rng) if turned else np.eye(3)
    p, q = p @ matrix, q @ matrix + 5 * turned
    value = report(p, q, device=DEVICE)
    assert f"nearly on a {name} (" in heading(value)[0]
    best = next(iter(value.tried))
    is_refused = best != value.recommended
    assert is_refused or name == "plane"
    assert (f"`{best.flags}` predicts best, but" in heading(value)[0]) == is_refused
    box = q.mean(axis=0) + np.ptp(q, axis=0).max() / 2 * rng.uniform(-1, 1, (300, 3))
    motion = q - p

    def sampled(settings):
        d = Deformation(p, q, device=DEVICE, **settings.options)
        moved = np.linalg.norm(d.backward(box) - box + motion.mean(axis=0), axis=1)
        return np.linalg.det(slopes(d, box, 1e-4)), np.quantile(moved, 0.85)

    largest = np.linalg.norm(motion - motion.mean(axis=0), axis=1).max()
    determinant, moved = sampled(value.recommended)
    assert np.mean((determinant > 0.1) & (determinant < 10)) > 0.85
    assert value.is_sensible
    assert moved < 3 * largest
    if is_refused:
        determinant, moved = sampled(best)
        assert np.mean((determinant > 0.1) & (determinant < 10)) < 0.5 or moved > 3 * largest


def test_pairs_without_a_sensible_map_are_reported(rng):
    p = np.c_[0 * Z, 0 * Z, Z] + rng.normal(0, 0.7, (18, 3))
    q = np.c_[0 * Z, 5 * np.cos(Z / 100), 1.05 * Z] + rng.normal(0, 0.7, (18, 3))
    value = report(p, q, device=DEVICE)  # their noise turns the map about the line
    assert not value.is_sensible
    assert any("no settings tried give a sensible map" in line for line in heading(value))


@pytest.mark.parametrize("scale", [1, 1e-3])
def test_extents_are_those_along_principal_axes(scale):
    rng = np.random.default_rng(0)
    box = np.stack(np.meshgrid(*[np.linspace(-1, 1, 3)] * 3), -1).reshape(-1, 3) * (50, 20, 3)
    shape = _shape(box @ random_rotation(rng) * scale, box * (1, 1, 5))
    np.testing.assert_allclose(shape.extents, np.array([100, 40, 6]) * scale)
    assert shape.is_thin
    assert not shape.is_line


@pytest.mark.parametrize("axis", range(3))
def test_a_mirror_is_reported_first(axis):
    rng = np.random.default_rng(axis)
    half = rng.uniform(-45, 45, (12, 3))
    sign = np.where(np.arange(3) == axis, -1, 1)
    p = np.concatenate([half, half * sign])
    # the names of both sides are mixed up, for another pose and size
    angle = 0.2
    turn = np.roll(np.roll([(np.cos(angle), np.sin(angle), 0), (-np.sin(angle), np.cos(angle), 0),
                            (0, 0, 1)], axis, 0), axis, 1)  # fmt: skip
    q = 1.1 * (p + rng.normal(0, 0.5, p.shape))[np.r_[12:24, 0:12]] @ turn + 7
    affine = np.linalg.lstsq(np.c_[p, np.ones(24)], q, rcond=None)[0][:3]
    assert np.linalg.det(affine) < 0
    value = report(p, q, device=DEVICE)
    assert heading(value)[0].startswith(
        "q is a mirror image of p (left and right are mixed up, or "
    )
    assert f"the axis {'xyz'[axis]} is turned around" in heading(value)[0]
    assert value.smallest_determinant > 0
    shape = _shape(p, q @ random_rotation(np.random.default_rng(5)))
    assert shape.mirror


def test_mirrors_are_claimed_for_mirrors_only():
    for seed in range(300):
        rng = np.random.default_rng(seed)
        count = int(rng.integers(4, 30))
        q = rng.uniform(-80, 80, (count, 3))
        p = smooth_warp(rng)(q) + rng.normal(0, 0.5, q.shape)
        assert not _shape(p, q @ random_rotation(rng)).mirror
        assert _shape(p * (1, -1, 1), q).mirror == "y" or count < 12
        flat = q * (1, 1, 0.01)  # a mirror on a plane is a rotation
        assert not _shape(flat * (-1, 1, 1), flat + rng.normal(0, 0.1, q.shape)).mirror
        assert not _shape(flat * (-1, 1, 1), flat).mirror
    p, q, _, swap = planted_pairs(np.random.default_rng(0))
    assert not _shape(p, q).mirror  # one pair of names is swapped
    assert report(p, q, device=DEVICE).swapped_with[swap[0]] == swap[1]


@pytest.mark.parametrize("moving", [1, 3])
def test_handles_of_a_drag_are_no_outliers(moving, rng):
    p = rng.uniform(-50, 50, (9, 3))
    q = p.copy()
    q[:moving] += (12, 5, 0)
    value = report(p, q, device=DEVICE)
    assert not value.outlier.any()
    assert value.swaps == []
    assert any(
        line.startswith("outliers: not looked for; most pairs rest") for line in heading(value)
    )
    content = json.loads(json.dumps(value.as_dict()))
    assert content["is_drag"]
    assert {"extents", "mirror", "is_sensible"} < {*content}
