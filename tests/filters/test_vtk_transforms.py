"""Transforms of VTK made from those of the package."""

import numpy as np
import pytest
from vtk_fixtures import FAST
from vtkmodules.vtkCommonTransforms import vtkGeneralTransform, vtkTransform

from vtk_mls import Affine, Chain, Deformation, Field, Grid
from vtk_mls.vtk.transforms import to_vtk_transform


def moved(transform, points):
    return np.array([transform.TransformPoint(point) for point in points.tolist()])


def affine(rng):
    return Affine(np.eye(4) + np.vstack([rng.normal(0, 0.1, (3, 4)), np.zeros(4)]))


def field(rng):
    """A field on a turned grid, one axis backward."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    grid = Grid((9, 8, 7), (1, 2, 3), (1.1, -1.2, 1.3), turn)
    return Field(rng.normal(0, 0.1, (*grid.shape, 3)), grid)


def deformation(rng):
    rest = rng.uniform(0, 8, (7, 3))
    return Deformation(rest, rest + rng.normal(0, 0.2, (7, 3)), device=FAST)


def inside(grid, rng, count=200):
    return grid.at(rng.uniform(0.05, 0.95, (count, 3)) * (np.array(grid.dimensions) - 1))


def test_affine_maps_and_fields_need_no_grid(rng):
    a, f, b = affine(rng), field(rng), affine(rng)
    between = inside(f.grid, rng)
    for chain, v in ((a, between), (f, between), (Chain([a, Chain([f, b])]), b.forward(between))):
        result = to_vtk_transform(chain)
        np.testing.assert_allclose(moved(result, v), chain.backward(v), atol=1e-5)
        x = chain.backward(v)
        np.testing.assert_allclose(moved(result.GetInverse(), x), v, atol=1e-4)


def test_the_error_of_a_sampled_map_falls_with_the_square_of_the_spacing(rng):
    chain = Chain([affine(rng), deformation(rng), affine(rng)])
    v, errors = rng.uniform(2, 6, (300, 3)), []
    for spacing in (0.8, 0.4, 0.2):
        count = int(9 / spacing)
        grid = Grid((count,) * 3, (-0.5, -0.5, -0.5), (spacing,) * 3)
        result = to_vtk_transform(chain, grid)
        errors.append(np.abs(moved(result, v) - chain.backward(v)).mean())
    assert errors[1] < errors[0] / 3
    assert errors[2] < errors[1] / 3
    points = grid.points_of(np.arange(0, grid.size, 97))
    x = chain.backward(points)
    np.testing.assert_allclose(moved(result, points), x, atol=1e-5)
    inside = ((points > 1) & (points < 7)).all(axis=1)
    np.testing.assert_allclose(moved(result.GetInverse(), x)[inside], points[inside], atol=1e-4)


def test_it_can_be_part_of_another_transform(rng):
    f = field(rng)
    shift, general = vtkTransform(), vtkGeneralTransform()
    shift.Translate(1, 2, 3)
    general.Concatenate(shift)
    general.Concatenate(to_vtk_transform(f))
    v = inside(f.grid, rng)
    np.testing.assert_allclose(moved(general, v), f.backward(v) + [1, 2, 3], atol=1e-5)


def test_bad_arguments_are_named(rng):
    with pytest.raises(TypeError, match="`transform` must be a Deformation, Affine, .* got 3"):
        to_vtk_transform(3)
    with pytest.raises(TypeError, match="`grid` must be a Grid, .* got None"):
        to_vtk_transform(deformation(rng))
