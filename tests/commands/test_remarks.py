"""What commands say, or refuse, when a map may not be what was meant."""

from pathlib import Path

import numpy as np
import pytest
from vtk_fixtures import DEFORMED, REST, add_scalars, make_image
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

from vtk_mls import Deformation, Grid, io
from vtk_mls.commands.cli import main
from vtk_mls.files import control_point_files
from vtk_mls.queries import arrival
from vtk_mls.vtk.arrays import ImageGeometry

COMMANDS = {
    "deform": ("in.vti", "out.vti"),
    "field": ("in.vti", "out.nrrd"),
    "field --jacobian": ("in.vti", "out.vti"),
    "points": ("in.csv", "out.csv"),
    "deform a series": ("in.vti", "out.pvd"),
}
FAR = (0, 0, 800)


def _write(name, rest, deformed):
    np.savetxt(name, np.hstack([rest, deformed]), delimiter=",", fmt="%.17g")


def _words(command, handles, *options):
    name, *flags = command.split()
    source, output = COMMANDS[command]
    flags = [flag for flag in flags if flag.startswith("--")]
    return [name, source, handles, output, *flags, *options]


@pytest.fixture
def inputs(files):
    """The folder with files of control points that rest."""
    _write("equal.csv", REST, REST)
    Path("rest.csv").write_text("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in REST))
    control_point_files.write("rest.fcsv", REST, REST)
    control_point_files.write("rest.mrk.json", REST, REST)
    Path("in.csv").write_text("x,y,z\n1,2,3\n4,5,6\n")
    return files


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    ("handles", "options", "sentence"),
    [
        ("equal.csv", [], "`equal.csv` has 8 control points, and each goes where it is (p = q); s"),
        ("rest.csv", [], "`rest.csv` has 8 positions, and not where they go; say where"),
        ("rest.fcsv", [], "`rest.fcsv` has 8 positions, and not where they go; say where"),
        (
            "rest.csv",
            ["--deformed", "rest.mrk.json"],
            "the 8 positions of `rest.mrk.json` are those of `rest.csv`; say where",
        ),
        ("handles.csv", ["--blend", "0"], "`--blend` is 0; give another, or add --allow-identity"),
    ],
)
def test_what_moves_nothing_is_an_error(inputs, command, handles, options, sentence, refused):
    before = sorted(inputs.rglob("*"))
    error = refused(*_words(command, handles, *options))
    assert error.startswith(f"nothing moves: {sentence}")
    assert sorted(inputs.rglob("*")) == before
    assert main(_words(command, handles, *options, "--allow-identity")) == 0


def test_the_editor_begins_with_what_rests(inputs, monkeypatch):
    states = []
    monkeypatch.setattr("vtk_mls.editor.window.show", lambda _, state, *more: states.append(state))
    assert main(["view", "in.vti", "equal.csv", "--window"]) == 0
    np.testing.assert_array_equal(states[0].deformed, REST)


@pytest.mark.parametrize("output", ["out.vti", "out.pvd", "out.vtm"])
def test_an_output_without_any_of_the_input_is_reported(inputs, output, capsys):
    """Whatever the values are: the background is that of the image."""
    image = add_scalars(make_image(), "ones", np.ones(504))
    io.write_dataset(image, "in.vti")
    _write("away.csv", REST, REST + FAR)
    source = "in.vti"
    if output == "out.vtm":
        blocks = vtkMultiBlockDataSet()
        blocks.SetBlock(0, image)
        blocks.SetBlock(1, image)
        io.write_dataset(blocks, "in.vtm")
        source = "in.vtm"
    arguments = ["deform", source, "away.csv", output]
    assert main(arguments) == 0
    assert capsys.readouterr().err == (
        f"vtk-mls: `{output}`: nothing of `{source}` is in the output, for the control points move "
        "it elsewhere; --grid fitted puts the output where it goes\n"
    )
    for options in (["--grid", "fitted"], ["--background", "nan"]):
        handles = "away.csv" if options[0] == "--grid" else "handles.csv"
        assert main(["deform", source, handles, output, *options]) == 0
        assert capsys.readouterr().err == ""


def test_what_few_points_show_is_not_called_nothing():
    """The material comes to one point of 65 x 65 x 65, which is between those looked at first."""
    source = Grid((2, 2, 2), (100, 100, 100), (0.1, 0.1, 0.1))
    target = Grid((65, 65, 65))
    index = np.array([(31, 31, 31)])
    assert not (arrival.coarse(target).points() == index).all(axis=1).any()
    deformation = Deformation(source.at([(0.5, 0.5, 0.5)]), index, device="reference")
    assert arrival.arrives(deformation, source, target)
    deformation = Deformation(source.at([(0.5, 0.5, 0.5)]), index + 0.5, device="reference")
    assert not arrival.arrives(deformation, source, target)


def test_some_time_steps_without_anything_are_counted(inputs, capsys):
    image = io.read_dataset("in.vti")
    io.write_dataset(image, "step_1.vti")
    image.SetOrigin(0, 0, 500)
    io.write_dataset(image, "step_2.vti")
    _write("away.csv", [(0, 0, 0), (0, 0, 500)], [(0, 0, 0.5), (0, 0, 900)])
    assert main(["deform", "step_*.vti", "away.csv", "out.pvd"]) == 0
    error = capsys.readouterr().err
    assert "nothing of `step_*.vti` is in 1 of 2 time steps of the output, for" in error


@pytest.mark.parametrize("rest", [(0, 0, 0), FAR])
@pytest.mark.parametrize("deformed", [(0, 0, 0.1), FAR])
def test_far_control_points_are_reported_on_the_side_of_the_data(inputs, rest, deformed, capsys):
    move = np.array([(0, 0, 0), *[(0.1, 0, 0)] * 7])
    _write("h.csv", REST + rest, REST + deformed + move)
    commands = ["deform", "out.vti"], ["field", "out.nrrd"], ["field", "out.nrrd", "--inverse"]
    sides = ("at rest (p)", rest), ("moved (q)", deformed), ("at rest (p)", rest)
    for (command, output, *options), (side, place) in zip(commands, sides):
        assert main([command, "in.vti", "h.csv", output, *options]) == 0
        is_reported = f"points, {side}, are far from the data: is" in capsys.readouterr().out
        assert is_reported == (place == FAR)


@pytest.mark.parametrize("command", ["deform", "field"])
def test_folds_are_reported(inputs, command, capsys):
    grid = ImageGeometry.of_image(io.read_dataset("in.vti")).grid
    low, high = grid.corners().min(axis=0), grid.corners().max(axis=0)
    rng = np.random.default_rng(3)
    rest = low + (high - low) * rng.random((10, 3))
    swapped = rest[rng.permutation(10)]
    _write("folding.csv", rest, swapped)
    assert main(_words(command, "folding.csv")) == 0
    value = Deformation(rest, swapped, device="reference")
    folded = np.linalg.det(value.jacobian(grid.points())) <= 0
    points = value.backward(grid.points())
    counts = grid.covers(grid.index_of(points)) if command == "deform" else np.ones(grid.size, bool)
    count, total = (folded & counts).sum(), counts.sum()
    assert 0 < count < total
    expected = f"; interpolated linearly, {value.certificate(grid)}"
    if command == "deform":
        expected = f"; the map folds at {count} of {total} sampled points ({count / total:.2%})"
    assert expected in capsys.readouterr().out
    assert main(_words(command, "handles.csv")) == 0
    value = Deformation(REST, DEFORMED, device="reference")
    assert (np.linalg.det(value.jacobian(grid.points())) > 0).all()
    assert "folds" not in capsys.readouterr().out
