"""Rigid regions: inside the map is the motion, outside they act by their distance."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import DEVICES, EVERYWHERE, KINDS_AND_DEGREES, deformation, random_rotation
from map_checks import check_inverse, check_jacobian, check_kernels
from pairwise import paired, rare
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import (
    Ball,
    Capsule,
    Deformation,
    Grid,
    HalfPlane,
    Labels,
    Plane,
    RegionHandle,
    Sampling,
    Solid,
)
from vtk_mls.vtk.objects import configured
from vtk_mls.vtk.shape_surfaces import surface_of, triangles_of

ALPHAS = [2, *rare(1, 1.7, 3)]
HALF_PLANE = HalfPlane((0, 0, -0.1), (0.2, 0.1, 1), (1, 0.3, 0))
CUTS = {
    "none": {},
    "moving": {"cuts": HALF_PLANE, "cut_frame": "rest"},
    "staying": {"cuts": HALF_PLANE, "cut_frame": "deformed"},
    "plane": {"cuts": Plane((0, 0, -0.1), (0, 0, 1)), "cut_frame": "rest"},
}


def motion(rng, shift=0.1, angle=0.5):
    """A rotation by up to `angle` about an axis through the origin, and a shift: (4, 4)."""
    axis = random_rotation(rng)[0]
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(3) - np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = turn, rng.normal(0, shift, 3)
    return result


def label(center, radius):
    """A ball as a label on an oblique grid with oblong voxels."""
    c, s = np.cos(0.4), np.sin(0.4)
    grid = Grid(
        (60, 70, 50), (-1, -1.2, -1.1), (0.04, 0.04, 0.05), [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    )
    inside = np.linalg.norm(grid.points() - center, axis=1) <= radius
    return Labels(inside.reshape(grid.shape), grid)


SHAPES = {
    "ball": lambda: Ball((0.4, 0.3, 0.5), 0.2),
    "capsule": lambda: Capsule((0.3, 0.3, 0.3), (0.5, 0.3, 0.8), 0.1),
    # the images of distances of these take a second or two: they are made once
    "solid": functools.cache(lambda: Solid(*surface_of(Ball((0.4, 0.3, 0.5), 0.2)))),
    "labels": functools.cache(lambda: label((0.4, 0.3, 0.5), 0.2)),
}


def scene(rng, shape="capsule", kind=("rigid", 1), device="reference", alpha=2.0, **options):
    """A moved shape, a capsule that stays, and points."""
    rest = rng.uniform(-1, 1, (6, 3)) - (0.3, 0.3, 0.5)
    still = RegionHandle(Capsule((-0.8, 0, -0.5), (-0.4, 0, -0.9), 0.1), np.eye(4))
    handles = [RegionHandle(SHAPES[shape](), motion(rng)), still]
    deformed = rest + rng.normal(0, 0.03, rest.shape)
    return deformation(rest, deformed, kind, device, alpha=alpha, handles=handles, **options)


def inside_of(handle, count=300):
    """Points (m, 3) inside of a region at rest, away from its surface."""
    low, high = handle.shape.bounds
    middle, size = (low + high) / 2, high - low
    points = middle + np.random.default_rng(1).uniform(-0.25, 0.25, (count, 3)) * size
    return points[handle.shape.distance(points)[0] == 0]


@paired(
    shape=SHAPES,
    kind=[("rigid", 1), *rare(*KINDS_AND_DEGREES[1:])],
    alpha=ALPHAS,
    device=EVERYWHERE,
)
def test_inside_the_map_is_the_motion(shape, kind, alpha, device, rng):
    d = scene(rng, shape, kind, device, alpha)
    for handle in d.handles:
        x = inside_of(handle)
        assert len(x) > 10
        np.testing.assert_allclose(d.backward(handle.moved(x)), x, atol=1e-5)
        np.testing.assert_allclose(d.forward(x), handle.moved(x), atol=2e-5)
        jacobian = d.jacobian(handle.moved(x[:20]))
        np.testing.assert_allclose(jacobian, [handle.motion[:3, :3].T] * 20, atol=1e-4)


def test_forward_finds_a_region_where_the_map_folds(device):
    turned = np.eye(4)
    turned[:2, :2], turned[:2, 3] = [(-1, 0), (0, -1)], (0, 0.6)
    handles = [
        RegionHandle(Ball((0, 0, 0), 0.2), turned),
        RegionHandle(Ball((0.5, 0, 0), 0.2), np.eye(4)),
    ]
    d = Deformation(handles=handles, device=device)
    x = inside_of(handles[0])
    np.testing.assert_allclose(d.forward(x), handles[0].moved(x), atol=1e-5)
    np.testing.assert_allclose(d.forward(x + (0.5, 0, 0)), x + (0.5, 0, 0), atol=1e-5)


def plain_rigid_map(v, handles, alpha):
    """The rigid map of balls alone, straight from Eq. 9 with weights 1 / distance^(2 alpha)."""
    sums = []
    for handle in handles:
        p, q = handle.proxies(1)
        distance = np.linalg.norm(v - handle.moved(handle.shape.center[None]), axis=1)
        distance = np.maximum(distance - handle.shape.radius, 1e-12)
        sums += [(distance ** (-2 * alpha) / len(p), *pair) for pair in zip(p, q)]
    total = sum(w for w, _, _ in sums)[:, None]
    p_star = sum(w[:, None] * p for w, p, _ in sums) / total
    q_star = sum(w[:, None] * q for w, _, q in sums) / total
    c = sum(w[:, None, None] * (p - p_star)[:, :, None] * (q - q_star)[:, None] for w, p, q in sums)
    u, _, vt = np.linalg.svd(c)
    turn = np.ones((len(v), 3))
    turn[:, 2] = np.linalg.det(u @ vt)
    rotation = (u * turn[:, None]) @ vt
    return np.einsum("mij,mj->mi", rotation, v - q_star) + p_star


@pytest.mark.parametrize("alpha", [1, 2])
def test_agrees_with_the_formula(alpha, device, rng):
    handles = [RegionHandle(Ball(rng.uniform(-0.7, 0.7, 3), 0.1), motion(rng)) for _ in range(5)]
    d = Deformation(handles=handles, alpha=alpha, device=device)
    v = rng.uniform(-1.5, 1.5, (20_000, 3))
    np.testing.assert_allclose(d.backward(v), plain_rigid_map(v, handles, alpha), atol=1e-5)


@paired(
    shape=SHAPES,
    kind=[*KINDS_AND_DEGREES[:2], *rare(*KINDS_AND_DEGREES[2:])],
    alpha=ALPHAS,
    cuts=["none", "moving", *rare("staying", "plane")],
    device=DEVICES,
)
def test_kernels_agree_with_the_specification(shape, kind, alpha, cuts, device, rng):
    specification = scene(rng, shape, kind, alpha=alpha, **CUTS[cuts])
    kernels = replace(specification, device=device)
    check_kernels(kernels, specification, rng.uniform(-1.2, 1.2, (2000, 3)), kind[1])


@paired(shape=SHAPES, kind=KINDS_AND_DEGREES, alpha=ALPHAS, cuts=CUTS)
def test_jacobian_is_the_slope(shape, kind, alpha, cuts, rng):
    d = scene(rng, shape, kind, alpha=alpha, **CUTS[cuts])
    check_jacobian(d, rng.uniform(-1.2, 1.2, (100, 3)))


@paired(
    shape=SHAPES,
    kind=[("rigid", 1), *rare(*KINDS_AND_DEGREES[1:])],
    cuts=["none", *rare("moving", "staying", "plane")],
    device=EVERYWHERE,
)
def test_forward_undoes_backward(shape, kind, cuts, device, rng):
    d = scene(rng, shape, kind, device, **CUTS[cuts])
    check_inverse(d, rng.uniform(-1, 1, (60, 3)))


def test_distance_from_a_solid(rng):
    ball = configured(vtkSphereSource(), Center=(0.4, 0.3, 0.5), Radius=0.2)
    shape = Solid(*triangles_of(configured(ball, ThetaResolution=80, PhiResolution=80)))
    x = rng.uniform(-0.5, 1.3, (5000, 3))
    distance, half = shape.distance(x)
    expected = np.maximum(np.linalg.norm(x - (0.4, 0.3, 0.5), axis=1) - 0.2, 0)
    np.testing.assert_allclose(distance, expected, rtol=0.03, atol=0.002)
    near = (expected > 0) & (expected < 0.1)  # in the image of distances
    np.testing.assert_allclose(distance[near], expected[near], atol=0.001)
    np.testing.assert_allclose(np.linalg.norm(half[near], axis=1), distance[near], atol=0.005)
    expected = np.linalg.norm(shape.image.grid.points() - (0.4, 0.3, 0.5), axis=1) - 0.2
    np.testing.assert_allclose(shape.image.values.ravel(), expected, atol=0.1 * shape.image.step)


def test_image_of_a_bone_keeps_its_voxels(rng):
    grid = Grid((40, 40, 40), (-1, -1, -1), (2 / 39,) * 3)
    bone = np.linalg.norm(grid.points() - (0.2, 0, 0), axis=1).reshape(grid.shape) < 0.4
    moved = np.eye(4)
    moved[0, 3] = 3 * 2 / 39  # three voxels
    still = RegionHandle(Ball((-0.9, -0.9, -0.9), 0.05), np.eye(4))
    d = Deformation(handles=[RegionHandle(Labels(bone, grid), moved), still])
    values = rng.random(grid.shape).astype(np.float32)
    (result,) = d.resample([values], Sampling(grid))
    expected = np.roll(np.where(bone, values, -1), 3, axis=2)
    inner = expected >= 0
    np.testing.assert_allclose(result[inner], expected[inner], atol=1e-4)


def test_image_of_labels_is_no_finer_than_its_voxels():
    grid = Grid((30, 30, 15), (-1, -1, -1), (0.05, 0.05, 0.1))
    inside = np.linalg.norm(grid.points() - (-0.3, -0.3, -0.3), axis=1).reshape(grid.shape) < 0.3
    inside[2, 3, 4] = True
    labels = Labels(inside, grid)
    assert labels.image.step == pytest.approx(0.05)
    distance, _ = labels.distance(grid.points())
    np.testing.assert_array_equal(distance == 0, inside.ravel())
    x = grid.points()[distance > 0]
    expected = np.linalg.norm(x[:, None] - grid.points()[inside.ravel()], axis=2).min(axis=1)
    np.testing.assert_allclose(distance[distance > 0], expected - 0.025, atol=0.02)


def test_overlap_is_reported():
    shift = np.eye(4)
    shift[0, 3] = -0.3
    still, near = RegionHandle(Ball((0, 0, 0), 0.5), np.eye(4)), Ball((1.2, 0, 0), 0.5)
    assert Deformation(handles=[still, RegionHandle(near, np.eye(4))]).overlapping_regions == []
    pairs = Deformation(handles=[still, RegionHandle(near, shift)]).overlapping_regions
    assert pairs == [(0, 1)]


def test_a_point_in_a_region_is_met(rng):
    handle = RegionHandle(Ball((0, 0, 0), 0.5), motion(rng))
    rest = np.array([(0.1, 0, 0.0)])
    deformed = handle.moved(rest) + 0.05
    for device in EVERYWHERE:
        d = Deformation(rest, deformed, handles=handle, device=device)
        np.testing.assert_allclose(d.residuals(), 0, atol=1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Ball((0, 0, 0), -1), "`radius` must be a positive number, got -1"),
        (lambda: Capsule((0, 0), (0, 0, 1), 1), "`a` must be three finite numbers"),
        (
            lambda: Solid([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]),
            "`triangles` must be a closed surface, got 3 edges with an open side",
        ),
        (
            lambda: Solid([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 3)]),
            "`triangles` must be rows of the 3 `points`, got 0 to 3",
        ),
        (
            lambda: Labels(np.zeros((2, 2, 2)), Grid((2, 2, 2))),
            "`mask` must have a voxel that is not 0",
        ),
        (
            lambda: Labels(np.ones((2, 2, 2)), Grid((3, 2, 2))),
            r"`mask` must have the shape \(2, 2, 3\) of `grid`, got \(2, 2, 2\)",
        ),
        (
            lambda: RegionHandle(Ball((0, 0, 0), 1), 2 * np.eye(4)),
            "`motion` must be a rotation and a translation",
        ),
        (
            lambda: RegionHandle(Ball((0, 0, 0), 1), np.diag([1, 1, -1, 1])),
            "`motion` must be a rotation and a translation",
        ),
        (lambda: RegionHandle("ball", np.eye(4)), "`shape` must be a Ball, Capsule"),
        (lambda: Deformation(handles="ball"), "`handles` must be CurveHandle or RegionHandle"),
    ],
)
def test_bad_arguments_are_refused(make, message):
    with pytest.raises((TypeError, ValueError), match=message):
        make()
