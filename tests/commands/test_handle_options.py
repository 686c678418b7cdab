"""Handles with a shape, masks and faces on the command line."""

import json
from pathlib import Path

import numpy as np
import pytest
from handle_surfaces import ball, displaced, joined, moved, polyline, positions, transform, volume
from pipelines import values_of
from vtk_fixtures import DEFORMED, FAST, REST, add_scalars, make_image

from vtk_mls import BallMask, Deformation, FixedFace, Plane, SlidingFace, io
from vtk_mls.commands.cli import main
from vtk_mls.vtk.arrays import ImageGeometry

CORNERS = np.array([(x, y, z) for x in (-6, 6) for y in (-6, 6) for z in (-6, 6)], float)
MOTION = transform()
CELLS = ["--handle-shapes", "cells"]
Y_PLANE = Plane((0, 4.25, 0), (0, 1, 0))


@pytest.fixture
def bones(files):
    """The folder with a bone that moves, and a mesh inside of it."""
    handles = joined(moved(ball((1, 0, 0), 2), MOTION), polyline(CORNERS, kind="Verts"))
    io.write_dataset(handles, "bones.vtp")
    io.write_dataset(ball((1, 0, 0), 1.2), "marrow.vtp")
    Path("in.csv").write_text("1,0,0\n0.5,0.5,-0.5\n")
    return files


def deform(*arguments):
    return main(["deform", *arguments])


def displacements(*options, grid="in.vti"):
    assert main(["field", grid, "handles.csv", "field.vti", *options]) == 0
    return values_of(io.read_dataset("field.vti"), "BackwardDisplacement")


def test_a_bone_stays_rigid(bones, caplog):
    assert deform("marrow.vtp", "bones.vtp", "out.vtp", *CELLS) == 0
    before, after = io.read_dataset("marrow.vtp"), io.read_dataset("out.vtp")
    expected = [MOTION.TransformPoint(point) for point in positions(before)]
    np.testing.assert_allclose(positions(after), expected, atol=2e-5)
    assert volume(after) == pytest.approx(volume(before), rel=1e-5)
    assert caplog.messages == []


def test_a_surface_at_rest_and_moved_are_a_pair_of_files(bones):
    bone = io.read_dataset("bones.vtp")
    rest, after = displaced(bone, 0), displaced(bone, 0)
    for point in range(bone.GetNumberOfPoints()):
        step = bone.GetPointData().GetArray("Displacement").GetTuple(point)
        after.GetPoints().SetPoint(point, np.add(bone.GetPoint(point), step))
    for name, surface in {"rest.vtp": rest, "after.vtp": after}.items():
        surface.GetPointData().Initialize()
        io.write_dataset(surface, name)
    assert deform("marrow.vtp", "rest.vtp", "pair.vtp", "--deformed", "after.vtp", *CELLS) == 0
    assert deform("marrow.vtp", "bones.vtp", "one.vtp", *CELLS) == 0
    pair, one = (positions(io.read_dataset(name)) for name in ("pair.vtp", "one.vtp"))
    np.testing.assert_allclose(pair, one, atol=1e-6)


def test_overlapping_bones_are_reported(bones, caplog, capsys):
    pushed = [moved(ball((x, 0, 0), 1), transform(0, move=(0, 0, 0.1))) for x in (-3, 0, 3)]
    pushed[1] = displaced(pushed[1], (2, 0, 0))
    io.write_dataset(joined(*pushed), "pushed.vtp")
    assert deform("marrow.vtp", "pushed.vtp", "out.vtp", *CELLS) == 0
    sentence = "rigid regions overlap where they were moved to: 1 and 2"
    assert caplog.messages == [sentence]
    assert main(["points", "in.csv", "pushed.vtp", "out.csv", *CELLS]) == 0
    assert f"; {sentence}" in capsys.readouterr().out


def _curve(name, nodes, kind="Curve"):
    points = [{"label": f"{kind}-{i + 1}", "position": node} for i, node in enumerate(nodes)]
    markups = {"type": kind, "coordinateSystem": "LPS", "controlPoints": points}
    Path(name).write_text(json.dumps({"markups": [markups]}))


@pytest.mark.parametrize(("kind", "count"), [("Curve", 3), ("ClosedCurve", 4)])
def test_curves_of_slicer(files, kind, count):
    nodes = np.array([(1, 1, 1), (3, 1, 1), (3, 4, 2)], float)
    _curve("rest.mrk.json", nodes.tolist(), kind)
    _curve("moved.mrk.json", (nodes + [0, 0, 1]).tolist(), kind)
    rest, deformed, _, handles = io.read_handles("rest.mrk.json", "moved.mrk.json")
    assert len(rest) == len(deformed) == 0
    (curve,) = handles
    rows = [0, 1, 2, 0][:count]
    np.testing.assert_array_equal(curve.rest, nodes[rows])
    np.testing.assert_array_equal(curve.deformed, nodes[rows] + [0, 0, 1])
    polydata = io.read_control_points("rest.mrk.json", "moved.mrk.json")
    assert (polydata.GetNumberOfLines(), polydata.GetNumberOfVerts()) == (1, 0)


@pytest.mark.parametrize("name", ["mask.vti", "mask.nii.gz", "mask.nrrd"])
def test_a_label_volume_is_a_mask(files, name):
    image = make_image()
    inside = np.zeros((7, 8, 9))
    inside[:, :, 5:] = 3
    io.write_dataset(add_scalars(image, "labels", inside.ravel(), 5), name)
    on_device = "--device", FAST  # in float32, as the places of NIfTI
    whole, part = displacements(*on_device), displacements("--mask", name, *on_device)
    assert not part[:, :, :5].any()
    np.testing.assert_allclose(part[:, :, 5:], whole[:, :, 5:], atol=1e-6)


LIMITS = {
    "--mask-ball=4,4,3,1.5,1": {"mask": BallMask((4, 4, 3), 1.5, 1)},
    "--fixed-plane=0,4.25,0,0,1,0,1": {"constraints": FixedFace(Y_PLANE, 1)},
    "--sliding-plane=0,4.25,0,0,1,0,1": {"constraints": SlidingFace(Y_PLANE, 1)},
}


@pytest.mark.parametrize("option", LIMITS)
def test_limits_are_those_of_the_value(files, option, caplog):
    value = Deformation(REST, DEFORMED, device="reference", **LIMITS[option])
    grid = ImageGeometry.of_image(io.read_dataset("in.vti")).grid
    expected = value.displacement_field(grid).displacement
    np.testing.assert_allclose(displacements(option), expected, atol=1e-6)
    (sentence,) = caplog.messages
    assert "handles are not met, by up to" in sentence


BAD = {
    "ball of four": (["--mask-ball", "0,0,0,1"], "`--mask-ball` must be 5 numbers with commas"),
    "no radius": (["--mask-ball", "1,2,3,0,1"], "`--mask-ball` is no ball: `radius` must be"),
    "plane": (["--fixed-plane", "0,0,0,0,0,0,1"], "`--fixed-plane` is no plane with a fall-off"),
    "words": (["--sliding-plane", "a,b"], "`--sliding-plane` must be 7 numbers with commas"),
    "no mask": (["--mask", "none.vti"], "`none.vti`"),
    "mesh as a mask": (["--mask", "marrow.vtp"], "`--mask` must be an image, got a vtkPolyData in"),
    "points as a mask": (["--mask", "handles.csv"], "`handles.csv`: its name must end in"),
    "gray mask": (["--mask", "in.vti"], "`in.vti` must have numbers from 0 to 1, got"),
    "two masks": (
        ["--mask", "labels.vti", "--mask-ball", "0,0,0,1,1"],
        "one mask, got `--mask-ball` and `--mask`",
    ),
}


@pytest.mark.parametrize("command", ["deform", "field", "points"])
@pytest.mark.parametrize("case", BAD)
def test_bad_limits(bones, command, case, refused):
    options, sentence = BAD[case]
    image = io.read_dataset("in.vti")
    image.GetPointData().SetActiveScalars("labels")
    io.write_dataset(image, "labels.vti")
    source, output = ("in.csv", "out.csv") if command == "points" else ("in.vti", "out.vti")
    assert sentence in refused(command, source, "handles.csv", output, *options)
    assert not Path(output).exists()


@pytest.mark.parametrize("command", ["deform", "points"])
def test_bad_surfaces_name_the_file(bones, command, refused):
    triangle = polyline([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (0, 0, 1), "Polys")
    io.write_dataset(triangle, "open.vtp")
    source, output = ("in.csv", "out.csv") if command == "points" else ("in.vti", "out.vti")
    error = refused(command, source, "open.vtp", output, *CELLS)
    assert error.startswith("`open.vtp`, surface 0, is no rigid region: ")
