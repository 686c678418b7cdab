"""3D Slicer reads our markups, and we read those that it writes."""

import json

import numpy as np
import pytest
from slicer_peer import needs_slicer, run

from vtk_mls.files import control_point_files
from vtk_mls.files.landmarks import Landmarks

pytestmark = needs_slicer

RAS = np.array([(1.5, -2, 3e-3), (4e5, 5, 6), (7, 8, 9)])
LPS = RAS * [-1, -1, 1]
LABELS, DESCRIPTIONS = ["nose, tip", 'left "eye" #1', "ear"], ["at rest, say", "", "none"]

READ = """
import json, sys
import slicer_core as slicer
from vtkmodules.vtkCommonMath import vtkMatrix3x3
scene = slicer.vtkMRMLScene()

def axes(node, i):
    matrix = vtkMatrix3x3()
    node.GetNthControlPointOrientationMatrix(i, matrix)
    return [matrix.GetElement(k, l) for k in range(3) for l in range(3)]

found = []
for path in sys.argv[1:]:
    if path.endswith(".csv"):
        node = slicer.vtkMRMLMarkupsFiducialNode()
        assert slicer.vtkSlicerMarkupsLogic.ImportControlPointsFromCSV(node, path)
    elif path.endswith(".fcsv"):
        node = slicer.vtkMRMLMarkupsFiducialNode()
        storage = slicer.vtkMRMLMarkupsFiducialStorageNode()
        scene.AddNode(node), scene.AddNode(storage)
        storage.SetFileName(path)
        assert storage.ReadData(node)
    else:
        storage = slicer.vtkMRMLMarkupsJsonStorageNode()
        scene.AddNode(storage)
        node = storage.AddNewMarkupsNodeFromFile(path)
        assert node, storage.GetUserMessages().GetAllMessagesAsString()
        assert not storage.GetUserMessages().GetNumberOfMessages()
    found.append([
        (
            node.GetNthControlPointPosition(i),
            node.GetNthControlPointLabel(i),
            node.GetNthControlPointDescription(i),
            node.GetNthControlPointPositionStatus(i) == node.PositionDefined,
            axes(node, i),
        )
        for i in range(node.GetNumberOfControlPoints())
    ])
print(json.dumps(found))
"""

WRITE = """
import json, sys
import slicer_core as slicer
scene = slicer.vtkMRMLScene()
kind, points = sys.argv[1], json.loads(sys.argv[2])
node = getattr(slicer, f"vtkMRMLMarkups{kind}Node")()
scene.AddNode(node)
for i, (place, label, description) in enumerate(points):
    node.AddControlPoint(*place)
    node.SetNthControlPointLabel(i, label)
    node.SetNthControlPointDescription(i, description)
node.UnsetNthControlPointPosition(2)
for path in sys.argv[3:]:
    is_lps = "lps" in path
    if path.endswith(".csv"):
        assert slicer.vtkSlicerMarkupsLogic.ExportControlPointsToCSV(node, path, is_lps)
        continue
    storage = getattr(
        slicer,
        f"vtkMRMLMarkups{'Fiducial' if path.endswith('fcsv') else 'Json'}StorageNode",
    )()
    scene.AddNode(storage)
    storage.SetFileName(path)
    storage.SetCoordinateSystem(int(is_lps))
    assert storage.WriteData(node)
"""


def _slicer_reads(*paths):
    return json.loads(run(READ, *paths).splitlines()[-1])


def _check(found, places, labels, descriptions, are_placed=(True, True, True)):
    rows = [row for row, is_placed in zip(found, are_placed) if is_placed]
    placed = np.flatnonzero(are_placed)
    np.testing.assert_allclose([row[0] for row in rows], np.array(places)[placed], rtol=1e-15)
    assert [row[1] for row in found] == labels
    assert [row[2] for row in found] == descriptions
    assert [row[3] for row in found] == list(are_placed)
    assert all(row[4] == np.eye(3).ravel().tolist() for row in found)  # axes are Slicer's own


def test_slicer_reads_what_we_write(tmp_path):
    control_point_files.write(tmp_path / "a.mrk.json", LPS, LPS, None, LABELS)
    control_point_files.write(tmp_path / "a.fcsv", LPS, LPS, None, LABELS)
    for found in _slicer_reads(tmp_path / "a.mrk.json", tmp_path / "a.fcsv"):
        _check(found, RAS, LABELS, ["", "", ""])

    with_gap = Landmarks("", np.where([[1], [0], [1]], LPS, np.nan), "LPS", LABELS, DESCRIPTIONS)
    control_point_files.write_landmarks(tmp_path / "b.mrk.json", with_gap)
    assert control_point_files.write_landmarks(tmp_path / "b.fcsv", with_gap) == 1
    first, second = _slicer_reads(tmp_path / "b.mrk.json", tmp_path / "b.fcsv")
    _check(first, RAS, LABELS, DESCRIPTIONS, (True, False, True))
    _check(second, RAS[[0, 2]], LABELS[::2], DESCRIPTIONS[::2], (True, True))


@pytest.mark.parametrize("kind", ["Fiducial", "ClosedCurve"])
def test_we_read_what_slicer_writes_and_slicer_what_we_make_of_it(tmp_path, kind):
    names = ["lps.mrk.json", "ras.mrk.json", "lps.fcsv", "ras.fcsv", "lps.csv", "ras.csv"]
    points = json.dumps(list(zip(RAS.tolist(), LABELS, DESCRIPTIONS)))
    run(WRITE, kind, points, *(tmp_path / name for name in names))
    for name in names:
        found = control_point_files.read_landmarks(tmp_path / name)
        np.testing.assert_allclose(found.positions[:2], LPS[:2], rtol=1e-15)
        assert found.is_placed.tolist() == [True, True, False]
        if name.endswith(".csv"):  # where Slicer does not double quotation marks; ours are ITK's
            continue
        assert found.labels == LABELS
        assert found.descriptions == DESCRIPTIONS
        places = np.array([LPS[1], (np.nan,) * 3, (1, 2, 3)])
        moved = Landmarks("", places, "LPS", found.labels, found.descriptions)
        new = tmp_path / f"new-{name}"
        left_out = control_point_files.write_landmarks(new, moved, tmp_path / name)
        assert left_out == name.endswith(".fcsv")
    for name, found in zip(names, _slicer_reads(*(tmp_path / f"new-{name}" for name in names[:4]))):
        is_placed = [True, True] if name.endswith(".fcsv") else [True, False, True]
        assert [row[3] for row in found] == is_placed, name
        np.testing.assert_allclose(found[0][0], RAS[1], rtol=1e-15)
        np.testing.assert_allclose(found[-1][0], (-1, -2, 3), rtol=1e-15)
