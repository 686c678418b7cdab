"""Paths of control points on the command line: a time series of their positions."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from command_fixtures import write_collection
from pipelines import values_of
from turned_column import CENTER, LEGS, REST, turned
from vtk_fixtures import FAST, add_array
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls import Deformation, io
from vtk_mls.commands.cli import main
from vtk_mls.editor import State
from vtk_mls.editor.handle_polydata import handle_values
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.control_point_polydata import fill_polydata

PLACES = [turned(k / LEGS) for k in range(LEGS + 1)]


def write_points(name, positions):
    if name.endswith(".csv"):
        np.savetxt(name, positions, "%.17g", ",")
    else:
        polydata = vtkPolyData()
        fill_polydata(polydata, positions, positions, None)
        polydata.GetPointData().RemoveArray("Displacement")
        io.write_dataset(polydata, name)


@pytest.fixture
def column(files):
    """The folder with the column at rest, rest.csv, and files of its turn."""
    write_points("rest.csv", REST)
    for ending in (".csv", ".vtp"):
        for number, places in enumerate(PLACES):
            write_points(f"turn_{number}{ending}", places)
    write_collection([(t / 10, f"turn_{t}.vtp") for t in range(1, LEGS + 1)], "turn.pvd")
    return files


def field(*arguments):
    assert main(["field", "in.vti", *arguments, "--device", FAST]) == 0
    return values_of(io.read_dataset("field.vti"), "BackwardDisplacement").reshape(-1, 3)


def assert_same(found, places=PLACES):
    """The field, at some points of its grid, is that of float64 along the places."""
    some = ImageGeometry.of_image(io.read_dataset("in.vti")).grid.points()[::101]
    d = Deformation(REST, places[-1], path=places[1:-1], device="reference")
    np.testing.assert_allclose(found[::101], d.backward(some) - some, atol=1e-6)


@pytest.mark.parametrize("series", ["turn_*.csv", "turn_*.vtp", "turn.pvd"])
def test_a_whole_turn(column, series):
    """With or without p itself: the collection begins after it."""
    assert_same(field("rest.csv", "field.vti", "--path", series))


def test_a_part_of_a_turn(column):
    found = field("rest.csv", "field.vti", "--path", "turn_*.csv", "--blend", "0.5")
    middles = [(a + b) / 2 for a, b in pairwise(PLACES)]
    places = [p for pair in zip(PLACES, middles) for p in pair][: LEGS + 1]
    assert_same(found, places)


def test_points_and_meshes_turn(column):
    series = ["--path", "turn_*.vtp"]
    assert main(["points", "rest.csv", "rest.csv", "out.csv", *series]) == 0
    np.testing.assert_allclose(io.read_landmarks("out.csv").positions, PLACES[-1], atol=1e-5)
    off = REST[:8] + (0.3, 0.2, 0)
    write_points("off.csv", off)
    d = Deformation(REST, PLACES[-1], path=PLACES[1:-1], device="reference")
    for handles in (["rest.csv", *series], ["column.vtp", *series[2:]]):
        io.write_handles("column.vtp", REST, PLACES[-1], between=PLACES[1:-1])
        assert main(["points", "off.csv", handles[0], "out.csv", *handles[1:]]) == 0
        np.testing.assert_allclose(
            io.read_landmarks("out.csv").positions, d.forward(off), atol=1e-5
        )


def test_all_points_may_come_back(column, capsys):
    """Handles that turn once around: they end where they began."""
    around = [
        (REST - CENTER) @ np.array([(c, s, 0), (-s, c, 0), (0, 0, 1)]) + CENTER
        for angle in np.linspace(0, 2 * np.pi, 9)
        for c, s in [(np.cos(angle), np.sin(angle))]
    ]
    io.write_handles("around.vtp", REST, REST, between=around[1:-1])
    assert np.abs(field("around.vtp", "field.vti")).max() < 1e-4
    assert "nothing moves" not in capsys.readouterr().out


def test_points_are_paired_by_labels(column):
    order = np.random.default_rng(1).permutation(len(REST))
    for name, places, rows in (
        ("rest.csv", REST, range(len(REST))),
        ("named_1.csv", PLACES[6], order),
        ("named_2.csv", PLACES[12], order[::-1]),
    ):
        lines = ["label,x,y,z", *(f"n{i},{','.join(map(repr, places[i].tolist()))}" for i in rows)]
        Path(name).write_text("\n".join(lines))
    found = field("rest.csv", "field.vti", "--path", "named_*.csv")
    assert_same(found, [REST, PLACES[6], PLACES[12]])


@pytest.mark.parametrize(
    ("options", "match"),
    [
        (
            ["--path", "less_*.csv"],
            "`less_1.csv` must hold one position for each of the 36 control",
        ),
        (["--path", "none_*.csv"], "there are no files `none_*.csv`"),
        (["--path", "double.pvd"], "`double.pvd` must have one file for each time, got 2 at 1.0"),
        (["--path", "turn.pvd", "--deformed", "turn_1.csv"], "leave `--deformed` out"),
        (["--path", "turn_0.csv"], "the 36 positions of `turn_0.csv` are those of `rest.csv`"),
    ],
)
def test_bad_series_are_errors(column, options, match, refused):
    write_points("less_0.csv", REST)
    write_points("less_1.csv", REST[:-1])
    write_points("less_2.csv", REST)
    write_collection([(1, "turn_1.vtp"), (1, "turn_2.vtp")], "double.pvd")
    assert match in refused("field", "in.vti", "rest.csv", "field.vti", *options)
    assert not Path("field.vti").exists()


def test_a_bad_array_is_an_error(files, refused):
    polydata = vtkPolyData()
    fill_polydata(polydata, REST, PLACES[-1], None)
    add_array(polydata.GetPointData(), "Path", np.zeros((len(REST), 2)), 11)
    io.write_dataset(polydata, "bad.vtp")
    line = refused("field", "in.vti", "bad.vtp", "field.vti")
    assert "bad.vtp" in line
    assert "must have 3 components per intermediate place" in line
    assert "got 2 components" in line


@pytest.mark.parametrize("shapes", ["points", "cells"])
def test_the_editor_takes_paths(column, shapes):
    io.write_handles("column.vtp", REST, PLACES[-1], between=PLACES[1:-1])
    values = handle_values(io.read_control_points("column.vtp"), shapes)
    d = Deformation(REST, PLACES[-1], path=PLACES[1:-1])
    for state in (State(**values), State.of(d)):
        np.testing.assert_allclose(state.path, PLACES[1:-1], atol=1e-12)
        np.testing.assert_allclose(state.deformation().backward(REST), d.backward(REST), atol=1e-6)
