"""Voids that cuts open, and gradients at their faces (section 4 of the paper)."""

from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import (
    DEVICES,
    EVERYWHERE,
    KINDS_AND_DEGREES,
    deformation,
    random_handles,
    random_rotation,
)
from cut_shapes import HALF_PLANE, SHAPES, are_apart, lengths
from pairwise import paired, rare

from vtk_mls import (
    CUT_FRAMES,
    VOID_VALUES,
    Deformation,
    Grid,
    HalfPlane,
    Plane,
    Sampling,
    Surface,
)


@pytest.mark.parametrize("shape", [name for name in SHAPES if name != "outside"])
def test_pulling_apart_opens_a_void(shape, device, rng):
    """Where the segment to the origin crosses a cut that stays, and nowhere else."""
    cuts = SHAPES[shape]
    deformed = rng.uniform(60, 200, (16, 3))
    side = np.where(deformed[:, 2:] > 128, 1, -1)
    rest = deformed - side * [0, 0, 12]
    d = Deformation(rest, deformed, device=device, cuts=cuts, cut_frame="deformed")
    v = rng.uniform(20, 230, (3000, 3))
    origin = d.backward(v)
    crossed = are_apart(cuts, v, origin)
    assert crossed.any()
    np.testing.assert_array_equal(d.void(v), crossed)


def test_the_opening_is_continuous(rng):
    for cut in (HALF_PLANE, SHAPES["polygon"][0], SHAPES["bent surface"][0]):
        for _ in range(20):
            (a, b), (g, h) = rng.uniform(20, 230, (2, 2, 3))
            t = np.linspace(0, 1, 2001)[:, None]
            v, origin = a + (b - a) * t, g + (h - g) * t
            change = np.abs(np.diff(cut.void_distance(v, origin)))
            crossed = cut.blocks(v[:-1], v[1:])  # v itself passes the cut
            assert change[~crossed].max() <= 1.5 * 370 / 2000


def test_continued_values_are_those_of_each_sides_map(device):
    """In the void the function goes on behind the face; elsewhere nothing changes."""
    cut = HalfPlane((16, 16, 10), (1, 0, 0), (0, 0, 1))
    d = pulled_apart(cut, device, cut_frame="rest")
    grid = Grid((33, 33, 33))
    image = waves(grid.points()).reshape(grid.shape)
    plain, continued = (
        d.resample([image], Sampling(grid, void_values=mode))[0] for mode in VOID_VALUES
    )
    void = d.displacement_field(grid.dimensions).void
    assert void.sum() > 500
    np.testing.assert_array_equal(continued[~void], plain[~void])
    assert (plain[void] == 0).all()
    origins = d.backward(grid.points()[void.ravel()])
    inside = (np.abs(origins - 16) < 15).all(axis=1)
    assert inside.sum() > 500
    np.testing.assert_allclose(continued[void][inside], waves(origins)[inside], atol=2e-3)
    with pytest.raises(ValueError, match="`void_values` must be one of background, cont.*'full'"):
        d.resample([image], Sampling(grid, void_values="full"))


@pytest.mark.parametrize("shape", SHAPES)
def test_openings_made_in_slabs_are_those_of_the_whole(shape, device, rng, monkeypatch):
    monkeypatch.setattr("vtk_mls.queries.fields.MAX_SLAB_POINTS", 500)
    rest, deformed = random_handles(rng, 12, 20)
    d = Deformation(rest, deformed, cuts=SHAPES[shape], device=device)
    grid = Grid((19, 17, 11), (-5, -5, -5), (14, 16, 26))
    for part in (grid, grid.part((3, 4, 2), (15, 11, 8))):
        whole = d.displacement_field(part)
        np.testing.assert_array_equal(d.void_distance_field(part), whole.void_distance)
        np.testing.assert_array_equal(d.void_field(part), whole.void)


def test_without_cuts_there_is_no_void(device, rng):
    d, grid = Deformation(*random_handles(rng, 5), device=device), Grid((4, 3, 2))
    field, cells = d.displacement_field(grid.dimensions), d.void_of_cells(grid)
    assert field.void_distance is None
    assert cells.at_center.shape == cells.touched.shape == grid.cells.shape
    assert not any(void.any() for void in (field.void, d.void_field(grid), *cells))
    resampled = np.zeros(grid.shape, np.float32)
    d.resample([resampled.copy()], grid, void_distance=resampled)
    for distance in (d.void_distance([[1, 2, 3]]), d.void_distance_field(grid), resampled):
        assert np.isposinf(distance).all()


# Gradients


def waves(x):
    return np.sin(x @ [0.04, 0.02, 0.01]) + np.cos(x @ [-0.02, 0.03, 0.02])


def waves_gradient(x):
    return np.cos(x @ [0.04, 0.02, 0.01])[:, None] * [0.04, 0.02, 0.01] - np.sin(
        x @ [-0.02, 0.03, 0.02]
    )[:, None] * [-0.02, 0.03, 0.02]


@paired(
    key=DEVICES or ["reference"],
    kind_and_degree=[*KINDS_AND_DEGREES[::3], *rare(*KINDS_AND_DEGREES[1:3])],
    normalise=[False, True],
)
def test_corrected_gradient_is_that_of_the_deformed_function(key, kind_and_degree, normalise, rng):
    """On an anisotropic, turned grid."""
    grid = Grid((60, 50, 40), (5, 6, 7), (1, 1.3, 1.7), random_rotation(rng))
    size = np.array(grid.dimensions)
    deformed = grid.at(rng.uniform(0, 1, (80, 3)) * size)
    rest = deformed + rng.normal(0, 0.5, deformed.shape)
    d = deformation(rest, deformed, kind_and_degree, key)
    image = waves(grid.points()).reshape(grid.shape)
    got = d.corrected_gradient(image, grid, normalise=normalise).reshape(-1, 3)
    v = grid.points()
    origin = d.backward(v)
    expected = np.einsum("mij,mi->mj", d.jacobian(v), waves_gradient(origin))
    sizes = lengths(expected)
    index = grid.index_of(origin)
    inner = ((index > 3) & (index < size - 4)).all(axis=1)
    if normalise:
        inner &= sizes > 0.3 * sizes.max()
        expected = expected / sizes[:, None]
    assert inner.mean() > 0.2
    error = lengths(got - expected)[inner] / lengths(expected)[inner].max()
    assert error.max() <= 1e-3


def pulled_apart(cut, device, by=3.0, cut_frame="deformed"):
    """Handles on both sides of a cut across x = 16, pulled apart above the middle."""
    deformed = np.array([(8, 8, 24), (24, 24, 24), (8, 24, 8), (24, 8, 8)], float)
    way = np.where(deformed[:, 2:] > 16, np.sign(deformed[:, :1] - 16), 0)
    rest = deformed - by * way * [1, 0, 0]
    return Deformation(rest, deformed, cuts=[cut], cut_frame=cut_frame, device=device)


OPENINGS = {
    "plane": Plane((16.3, 16, 10.2), (1, 0.2, 0.1)),
    "half-plane": HalfPlane((16.3, 16, 10.2), (1, 0.2, 0.1), (0, 0, 1)),
    "polygon": Surface.polygon([(16.3, -9, 10), (16.3, 40, 10), (17.3, 40, 50), (17.3, -9, 50)]),
}


OPTIONS = {
    "rest": {},
    "deformed": {"cut_frame": "deformed"},
    "between nodes": {"map_tolerance": 0.05},
    "two cuts": {"cuts": [OPENINGS["plane"], HalfPlane((16, 16, 10), (0.1, 0.2, 1), (0, 1, 0))]},
}


@paired(shape=OPENINGS, option=OPTIONS, device=EVERYWHERE)
def test_a_resampling_tells_the_void_distances_of_the_grid(shape, option, device, rng):
    d = replace(pulled_apart(OPENINGS[shape], device, cut_frame="rest"), **OPTIONS[option])
    grid = Grid((23, 19, 17), (-2, -1, 0), (1.6, 1.8, 2))
    array = rng.uniform(size=grid.shape).astype(np.float32)
    for part in (grid, grid.part((3, 4, 2), (18, 13, 11))):
        expected = d.void_distance_field(part)
        assert 0 < (expected < 0).sum() < part.size
        for void_values in VOID_VALUES:
            sampling = Sampling(grid, part, void_values=void_values)
            got = np.full(part.shape, np.nan, np.float32)
            (values,) = d.resample([array], sampling, void_distance=got)
            np.testing.assert_allclose(got, expected, atol=1e-4)
            np.testing.assert_array_equal(values, d.resample([array], sampling)[0])


@pytest.mark.parametrize(
    "bad",
    [np.zeros((4, 3, 2)), np.zeros((2, 3, 4), "f4"), np.zeros((4, 3, 2, 2), "f4")[..., 0], "all"],
    ids=["float64", "shape", "strided", "no array"],
)
def test_void_distances_that_cannot_be_filled_are_refused(bad):
    d, grid = Deformation([[0, 0, 0]], [[1, 0, 0]], device="reference"), Grid((2, 3, 4))
    with pytest.raises(ValueError, match="`void_distance` must be a writeable, contiguous array"):
        d.resample([np.zeros(grid.shape)], grid, void_distance=bad)


@pytest.mark.parametrize("shape", OPENINGS)
@pytest.mark.parametrize(("normalise", "cut_frame"), [(False, "deformed"), (True, "rest")])
def test_devices_agree_on_gradients_at_an_opening(shape, normalise, cut_frame, key):
    grid = Grid((17, 17, 17), spacing=(2, 2, 2))
    image = 3 + waves(grid.points()).reshape(grid.shape)
    expected, got = (
        pulled_apart(OPENINGS[shape], device, cut_frame=cut_frame).corrected_gradient(
            image, grid, normalise=normalise
        )
        for device in ("reference", key)
    )
    error, allowed = lengths(got - expected), 1e-3 * lengths(expected).max()
    assert np.mean(error > allowed) <= 2e-4


@pytest.mark.parametrize("cut_frame", CUT_FRAMES)
@pytest.mark.parametrize("shape", OPENINGS)
def test_a_closed_cut_has_no_face(shape, cut_frame, device):
    d = pulled_apart(OPENINGS[shape], device, 0, cut_frame)
    grid = Grid((17, 17, 17), spacing=(2, 2, 2))
    image = 3 + waves(grid.points()).reshape(grid.shape)
    plain = Deformation(d.rest, d.deformed, device=device).corrected_gradient(image, grid)
    np.testing.assert_allclose(d.corrected_gradient(image, grid), plain, rtol=0, atol=1e-6)


@pytest.mark.parametrize("cut_frame", CUT_FRAMES)
@pytest.mark.parametrize("shape", OPENINGS)
def test_gradients_turn_smoothly_to_the_face(shape, cut_frame):
    """From that inside to across the face, over a voxel, wherever the voxels lie."""
    d = pulled_apart(OPENINGS[shape], "reference", cut_frame=cut_frame)
    source = Grid((33, 33, 33))
    image = 3 + waves(source.points()).reshape(source.shape)
    line = Grid((1601, 1, 1), (12, 16, 22), (0.01, 1, 1))
    slopes = d.corrected_gradient(image, Sampling(source, line))[0, 0]
    (void_distance,) = (d.void_distance(line.points()),)
    solid = void_distance >= 0
    assert (slopes[~solid] == 0).all()
    both = solid[1:] & solid[:-1]
    assert lengths(np.diff(slopes, axis=0))[both].max() < 0.05 * lengths(slopes).max()
    at_face = np.flatnonzero(solid[1:] != solid[:-1])
    assert len(at_face) == 2
    for place in (at_face[0], at_face[1] + 1):
        # across the face, as long as the step in one voxel of the undeformed image
        epsilon = 1e-5 * np.eye(3)
        v = line.points()[[place]]
        across = [(d.void_distance(v + e) - d.void_distance(v - e)).item() / 2e-5 for e in epsilon]
        (value,) = d.resample([image], Sampling(source, Grid((1, 1, 1), v[0])))
        np.testing.assert_allclose(slopes[place], value.item() * np.array(across), rtol=0.03)


def test_points_next_to_a_cut_are_nearest_to_its_inside():
    x = np.array([(0.3, 0.2, 0.5), (-0.3, 0.2, 0.5), (0, 0, 3)])
    square = Surface.polygon([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    half = HalfPlane((0, 0, 0), (0, 0, 1), (1, 0, 0))
    for cut in (square, half):
        assert cut.is_over(x).tolist() == [True, False, False]
    assert Plane((0, 0, 0), (0, 0, 1)).is_over(x).all()


@pytest.mark.parametrize("shape", [*SHAPES, "plane"])
def test_away_is_the_slope_of_the_opening(shape, rng):
    cut = SHAPES[shape][0] if shape in SHAPES else OPENINGS["plane"]
    v = rng.uniform(20, 230, (400, 3))
    if isinstance(cut, Surface):
        g = cut.points[cut.triangles].mean(axis=1)[rng.integers(len(cut.triangles), size=400)]
    elif isinstance(cut, Plane):
        g = v - cut.height(v)[:, None] * cut.normal
    else:
        g = cut.point + rng.uniform(5, 50, (400, 2)) @ [cut.inward, cut.along]
    g = g + rng.normal(0, 0.02, g.shape)
    slope = np.stack(
        [
            (cut.void_distance(v, g + e) - cut.void_distance(v, g - e)) / 2e-6
            for e in 1e-6 * np.eye(3)
        ],
        axis=1,
    )
    agreeing = lengths(slope - cut.away(v, g)) < 1e-3
    assert agreeing.mean() > 0.97  # the others lie within the difference of the surface or a fold


def test_pushed_vectors_move_with_the_material(device, rng):
    rest, deformed = random_handles(rng, 12)
    grid = Grid((17, 18, 19), (0, 0, 0), (15, 14, 14), random_rotation(rng))
    vectors = np.tile(np.array([1.0, -2.0, 0.5]), (*grid.shape, 1))
    d = Deformation(rest, deformed, device=device)
    pushed = d.resample_vectors(vectors, grid)
    specification = Deformation(rest, deformed, device="reference")
    v = grid.points()
    origin, step = specification.backward(v), 1e-3
    inside = (np.abs(grid.index_of(origin) / (np.array(grid.dimensions) - 1) - 0.5) < 0.5).all(1)
    # dF/dx w by differences of the forward map, where it leads back to v
    ahead = specification.forward(origin[inside] + step * vectors[0, 0, 0])
    behind = specification.forward(origin[inside] - step * vectors[0, 0, 0])
    true = (ahead - behind) / (2 * step)
    is_close = np.linalg.norm((ahead + behind) / 2 - v[inside], axis=1) < 0.1
    assert is_close.mean() > 0.9
    error = np.abs(pushed.reshape(-1, 3)[inside] - true)[is_close]
    assert np.quantile(error, 0.99) < 2e-3
