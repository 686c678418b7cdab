"""`vtk-mls points` moves landmarks as the deformation moves the material."""

import csv
import json

import numpy as np
import pytest
import SimpleITK as sitk
from vtk_fixtures import DEFORMED, FAST, REST

from vtk_mls import Deformation, Grid, Plane
from vtk_mls.commands.cli import main
from vtk_mls.files import control_point_files, formats
from vtk_mls.files.landmarks import Landmarks

LABELS = [f"place {i}" for i in range(5)]
PLACES = np.random.default_rng(13).uniform(2, 6, (5, 3))
# Half of the material goes away from a plane and leaves a void behind.
APART = "px,py,pz,qx,qy,qz\n" + "".join(
    f"{x},{y},{z},{x + 2 * (x > 0)},{y},{z}\n" for x in (-4, 4) for y in (-3, 3) for z in (-3, 3)
)


@pytest.fixture
def landmarks(files):
    """Landmarks in a file of each kind."""
    points = Landmarks("", PLACES, "LPS", LABELS, ["first", "", "", "", "last"])
    for suffix in formats.endings(reads=(formats.POINTS,)):
        control_point_files.write_landmarks(f"in{suffix}", points)
    return points


def _points(*arguments):
    return main(["points", *arguments])


@pytest.mark.parametrize("suffix", formats.endings(reads=(formats.POINTS,)))
@pytest.mark.parametrize("option", ["--kind=rigid", "--inverse", "--cut-plane=4,4,4,0,0,1"])
def test_landmarks_of_every_format_move_with_the_material(landmarks, suffix, option, capsys):
    assert _points(f"in{suffix}", "handles.csv", f"out{suffix}", option) == 0
    cuts = [Plane((4, 4, 4), (0, 0, 1))] if "cut" in option else []
    value = Deformation(REST, DEFORMED, cuts=cuts, device="reference")
    expected = (value.backward if option == "--inverse" else value.forward)(PLACES)
    landmarks = control_point_files.read_landmarks(f"out{suffix}")
    np.testing.assert_allclose(landmarks.positions, expected, rtol=1e-12)
    assert np.abs(landmarks.positions - PLACES).max() > 0.1
    if suffix not in (".txt", ".pts"):
        assert landmarks.labels == LABELS
    if suffix not in (".txt", ".pts", ".tag"):
        assert landmarks.descriptions == ["first", "", "", "", "last"]
    assert capsys.readouterr().out == f"out{suffix}: 5 points, rigid\n"


def test_what_itk_reads_goes_back_by_the_displacement_field(landmarks):
    assert _points("in.mrk.json", "handles.csv", "out.csv") == 0
    with open("out.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    moved = [[float(row[axis]) for axis in "xyz"] for row in rows]
    assert [(row["t"], row["label"]) for row in rows] == [("0", label) for label in LABELS]
    grid = Grid((81, 81, 81), (0, 0, 0), (0.1, 0.1, 0.1))
    value = Deformation(REST, DEFORMED, device=FAST)
    field = value.displacement_field(grid.dimensions, grid.origin, grid.spacing).displacement
    image = sitk.GetImageFromArray(field.astype(np.float64), isVector=True)
    image.SetSpacing(grid.spacing.tolist())
    transform = sitk.DisplacementFieldTransform(image)
    back = [transform.TransformPoint(place) for place in moved]
    np.testing.assert_allclose(back, PLACES, atol=2e-3)  # linear between places 0.1 apart


def test_frames_of_landmarks_and_handles(landmarks):
    handles = np.hstack([REST, DEFORMED]) * ([-1, -1, 1] * 2)
    np.savetxt("ras.csv", handles, delimiter=",", fmt="%.17g")
    np.savetxt("ras.txt", PLACES * [-1, -1, 1], fmt="%.17g")
    assert _points("ras.txt", "ras.csv", "out.txt", "--handles-space", "ras") == 0
    assert _points("in.fcsv", "handles.csv", "out.fcsv") == 0
    assert _points("in.fcsv", "ras.csv", "again.fcsv", "--handles-space", "ras") == 0
    expected = control_point_files.read_landmarks("out.fcsv").positions
    np.testing.assert_allclose(
        np.loadtxt("out.txt", skiprows=1, delimiter=","), expected * [-1, -1, 1], rtol=1e-12
    )
    landmarks = control_point_files.read_landmarks("again.fcsv").positions
    np.testing.assert_allclose(landmarks, expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "fate"),
    [("out.mrk.json", "marked so"), ("out.csv", "left out"), ("out.txt", "left out")],
)
def test_points_in_a_void_are_reported(files, name, fate, capsys):
    (files / "apart.csv").write_text(APART)
    places = np.array([(-2.0, 0, 0), (1, 0, 0), (0.5, 1, 1), (5, 0, 0), (np.nan,) * 3])
    points = Landmarks("", places, "LPS", ["a", "b", "", "d", "e"])
    control_point_files.write_landmarks("in.mrk.json", points)
    options = ["--inverse", "--cut-plane", "0,0,0,1,0,0"]
    assert _points("in.mrk.json", "apart.csv", name, *options) == 0
    text = f"{name}: 5 points, rigid; 2 have no place in the output and are {fate}: `b`, `3`"
    if fate == "left out":
        text += "; 1 are not placed in `in.mrk.json` and are left out"
    assert capsys.readouterr().out == text + "\n"
    landmarks = control_point_files.read_landmarks(name)
    placed = landmarks.positions[landmarks.is_placed]
    np.testing.assert_allclose(placed, [(-2, 0, 0), (3, 0, 0)], atol=1e-5)
    if fate == "marked so":
        statuses = [
            point["positionStatus"]
            for point in json.loads((files / name).read_text())["markups"][0]["controlPoints"]
        ]
        assert statuses == ["defined", "undefined", "undefined", "defined", "undefined"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["in.vti", "handles.csv", "out.csv"], "cannot read control points from `in.vti`: its"),
        (["in.csv", "handles.csv", "out.vti"], "cannot write points to `out.vti`: its name must"),
        (["none.csv", "handles.csv", "out.csv"], "there is no file `none.csv`"),
        (["in.csv", "in.mrk.json", "out.csv", "--deformed=no.csv"], "there is no file `no.csv`"),
        (["in.csv", "places.txt", "out.csv"], "`places.txt`, line 1: expected numbers px,py,pz,q"),
        (["in.csv", "far.csv", "out.csv"], "`rest` must be within 1e+37, the range of"),
    ],
)
def test_errors_are_one_sentence(landmarks, arguments, sentence, refused):
    np.savetxt("places.txt", PLACES)
    np.savetxt("far.csv", np.hstack([REST, DEFORMED]) * 1e40, delimiter=",")
    assert refused("points", *arguments).startswith(sentence)
