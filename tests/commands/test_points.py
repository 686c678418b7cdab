"""`vtk-mls points` moves landmarks as the deformation moves the material; `check` reports them."""

import csv
import json

import numpy as np
import pytest
import SimpleITK as sitk
from vtk_fixtures import DEFORMED, FAST, REST

from vtk_mls import Chain, Deformation, Field, Grid, Plane, io
from vtk_mls.commands.cli import main
from vtk_mls.files import control_point_files, formats
from vtk_mls.files.landmarks import Landmarks
from vtk_mls.landmarks import report
from vtk_mls.vtk import arrays

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


# --initial-transform: a warp of another program is corrected by hand


@pytest.fixture
def initial(files):
    """A field, in the file warp.nrrd."""
    grid = Grid((5, 5, 5), (-1, -1, -1), (2.5, 2.5, 2.5))
    value = Field(np.random.default_rng(3).normal(0, 0.3, (*grid.shape, 3)), grid)
    io.write_transform(value, "warp.nrrd")
    return value


def corrected(name, *arguments):
    return main([name, *arguments, "--initial-transform", "warp.nrrd"])


def test_handles_at_rest_leave_the_initial_transform(initial, capsys):
    """They would be an error without it: nothing would move."""
    control_point_files.write("rest.csv", REST, REST)
    assert corrected("deform", "in.vti", "rest.csv", "out.vti") == 0
    assert "nothing moves" not in capsys.readouterr().out
    image, output = (io.read_dataset(name) for name in ("in.vti", "out.vti"))
    values = [arrays.to_numpy(data.GetPointData().GetScalars()) for data in (image, output)]
    assert (values[0] != values[1]).any()


@pytest.mark.parametrize("inverse", [False, True])
def test_points_after_an_initial_transform(initial, inverse):
    control_point_files.write_landmarks("in.csv", Landmarks("", PLACES, "LPS", list("abcde")))
    option = ["--inverse"] * inverse
    assert corrected("points", "in.csv", "handles.csv", "out.csv", *option) == 0
    chain = Chain([initial, Deformation(REST, DEFORMED, device="reference")])
    expected = (chain.backward if inverse else chain.forward)(PLACES)
    got = control_point_files.read_landmarks("out.csv").positions
    np.testing.assert_allclose(got, expected, rtol=1e-9)
    assert np.abs(got - chain.transforms[1].forward(PLACES)).max() > 0.05


def test_a_missing_initial_transform_is_named(initial, refused):
    arguments = "deform", "in.vti", "handles.csv", "out.vti", "--initial-transform", "no.h5"
    assert refused(*arguments) == "there is no file `no.h5`"


# `vtk-mls check`


@pytest.fixture
def pairs(files):
    """p and q of 24 pairs in files; the labels `place 3` and `place 8` are swapped."""
    rng = np.random.default_rng(4)
    q = rng.uniform(-50, 50, (24, 3))
    p = q + 3 * np.sin(q[:, [1, 2, 0]] / 40)
    q[[3, 8]] = q[[8, 3]]
    labels = [f"place {i}" for i in range(24)]
    for name, points in (("p", p), ("q", q)):
        control_point_files.write_landmarks(
            f"{name}.mrk.json", Landmarks("", points, "LPS", labels)
        )
    control_point_files.write("pairs.csv", p, q)
    return p, q, labels


def test_the_report_of_two_files(pairs, files, capsys):
    p, q, labels = pairs
    outputs = ["--json", "r.json", "--html", "r.html"]
    assert main(["check", "p.mrk.json", "--deformed", "q.mrk.json", *outputs]) == 0
    expected = report(p, q, labels, device="reference")
    content = json.loads((files / "r.json").read_text())
    assert [pair["name"] for pair in content["pairs"]] == labels
    np.testing.assert_allclose([x["error"] for x in content["pairs"]], expected.error, atol=1e-9)
    assert content["pairs"][3]["swapped_with"] == "place 8"
    assert content["pairs"][8]["swapped_with"] == "place 3"
    assert "place 8" in (files / "r.html").read_text()
    text = capsys.readouterr().out
    lines = text.splitlines()
    assert {line.split("  ")[0] for line in lines[1:3]} == {"place 3", "place 8"}
    assert "labels that look swapped: place 3 and place 8" in lines
    assert f"take: {expected.recommended.flags}" in lines
    assert "the map" in lines[-1]


def test_the_options_to_take_are_those_of_deform(pairs, capsys):
    assert main(["check", "pairs.csv"]) == 0
    lines = capsys.readouterr().out.splitlines()
    flags = next(line for line in lines if line.startswith("take: "))[6:].split()
    control_point_files.write_landmarks("in.csv", Landmarks("", pairs[1][:3], "LPS"))
    command = ["points", "in.csv", "pairs.csv", "out.csv", "--inverse"]
    assert main([*command, *flags]) == 0


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        (["0,0,0,1,0,0"] * 1, "`few.csv` must have at least 4 pairs"),
        (["0,0,0,1,0,0", "0,0,0,2,0,0", "1,2,3,4,5,6", "3,2,1,5,5,5"], "p of `few.csv` must be"),
    ],
)
def test_wrong_pairs_are_one_sentence(files, refused, lines, sentence):
    (files / "few.csv").write_text("px,py,pz,qx,qy,qz\n" + "\n".join(lines) + "\n")
    assert refused("check", "few.csv").startswith(sentence)


def test_positions_without_partners(pairs, refused):
    assert "and not where they go" in refused("check", "p.mrk.json")
