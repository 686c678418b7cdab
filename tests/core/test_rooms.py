"""What is found in the rooms of kinds and of cuts."""

import numpy as np
import pytest

import vtk_mls
from vtk_mls.base.resources import resource
from vtk_mls.model import cuts, kinds

PAPER = ("affine", "rigid", "similarity", "polynomial")


def test_kinds_are_in_the_order_of_the_paper():
    assert vtk_mls.KINDS[: len(PAPER)] == PAPER


@pytest.mark.parametrize("name", vtk_mls.KINDS)
def test_a_kind_names_its_kernel_file_and_numbers_for_it(name):
    d = vtk_mls.Deformation(np.eye(3), 2 * np.eye(3), name)
    points = d.regions[0].control_points
    assert (resource("opencl") / "fit" / points.kind.kernel).is_file()
    assert points.kind.name == name
    assert points.kind.table(points).dtype == np.float32
    assert set(points.kind.params(points)) <= {"rank", "flip_axis"}


def test_full_planes_are_no_obstacles_and_all_others_are():
    assert cuts.SHAPES[0] == "Plane"
    assert {"HalfPlane", "Surface"} <= set(cuts.SHAPES)
    for name in cuts.SHAPES[1:]:
        shape = getattr(cuts, name)
        assert issubclass(shape, cuts.Obstacle)
        assert (resource("opencl") / "cuts" / f"cut_{shape.kernel}.cl").is_file()


def test_only_the_polynomial_kind_has_a_degree():
    assert [name for name in PAPER if kinds.named(name, 2).has_degree] == ["polynomial"]
