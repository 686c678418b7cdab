"""Control points from text files and to them."""

import json

import numpy as np
import pytest
from pipelines import update

from vtk_mls.files import control_point_files
from vtk_mls.filters import MLSControlPoints
from vtk_mls.vtk import arrays

REST = np.array([(1.25, -2, 3e-9), (4e5, 5, 6)])
DEFORMED = REST + [(0.5, 0, 0), (0, 1e-3, 0)]


@pytest.mark.parametrize("name", ["x.csv", "x.TXT"])
@pytest.mark.parametrize("weights", [None, [2.0, 0.1]])
def test_a_table_gives_back_what_it_got(tmp_path, name, weights):
    control_point_files.write(tmp_path / name, REST, DEFORMED, weights)
    rest, deformed, found = control_point_files.read(tmp_path / name)
    np.testing.assert_array_equal(rest, REST)
    np.testing.assert_array_equal(deformed, DEFORMED)
    assert (found is None) if weights is None else found.tolist() == weights


@pytest.mark.parametrize(("system", "sign"), [("LPS", 1), ("1", 1), ("RAS", -1), ("0", -1)])
def test_fiducials_of_both_conventions(tmp_path, system, sign):
    path = tmp_path / "x.fcsv"
    path.write_text(
        "# Markups fiducial file version = 4.10\n"
        f"# CoordinateSystem = {system}\n"
        "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
        "vtkMRMLMarkupsFiducialNode_0,1,2,3,0,0,0,1,1,1,0,nose,,vtkMRMLScalarVolumeNode1\n"
    )
    assert control_point_files.read(path)[0].tolist() == [[sign, 2 * sign, 3]]


@pytest.mark.parametrize(
    "text",
    ["1,5;2;3;4;5;-6,25\n", "px;py;pz;qx;qy;qz\n1,5;2,0;3;4;5;-6,25\n", "a;1,5;2;3;4;5;-6.25\n"],
)
def test_a_table_with_semicolons_may_have_decimal_commas(tmp_path, text):
    path = tmp_path / "points.csv"
    path.write_text(text)
    rest, deformed, *_ = control_point_files.read(path)
    assert (rest.tolist(), deformed.tolist()) == ([[1.5, 2, 3]], [[4, 5, -6.25]])


def test_semicolons_in_a_label_part_nothing(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text("a;b;c,1,2,3,4,5,6\n")
    assert control_point_files.read(path)[0].tolist() == [[1, 2, 3]]


def _markups(positions, system="LPS"):
    points = [{"id": "1", "position": position} for position in positions]
    return json.dumps({"markups": [{"coordinateSystem": system, "controlPoints": points}]})


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("x.csv", "px,py,pz\n", r"x\.csv` holds no control points"),
        ("x.csv", 10**6 * "1,", r"x\.csv`, line 1: expected numbers .*1,\.\.\.` of 2000000 char"),
        ("x.fcsv", "# nothing\n", r"x\.fcsv` holds no control points"),
        ("x.fcsv", "a,1,2\n", r"x\.fcsv` has a position that is not three numbers"),
        ("x.mrk.json", "{", r"x\.mrk\.json` has no markups"),
        ("x.json", "{}", r"must end in one of .*\.mrk\.json"),
        ("x.csv", "1,2,3,4,5,inf\n", r"x\.csv` has a coordinate that is not a finite number"),
        ("x.csv", "1,2,3,4,5,6,-1\n", r"x\.csv` has a weight that is not a positive number"),
        ("x.csv", "9" * 200_000, r"x\.csv`, line 1: field larger than field limit"),
        ("x.csv", "1,\udcff", r"x\.csv` is not UTF-8 text: its byte 2 is 255"),
        ("x.fcsv", "a,1,2,nan", r"x\.fcsv` has a coordinate that is not a finite number"),
        ("x.mrk.json", "[" * 100_000, r"x\.mrk\.json` has no markups: it is nested too"),
        ("x.mrk.json", '"\udcff"', r"x\.mrk\.json` is not UTF-8 text"),
        (
            "x.mrk.json",
            _markups([[1, 2, 10**400]]),
            r"x\.mrk\.json` has a position that is not thr",
        ),
        ("x.mrk.json", _markups([[1, 2, 3]], ["LPS"]), r"has the coordinate system \['LPS'\]; it"),
    ],
)
def test_bad_files(tmp_path, name, text, sentence):
    (tmp_path / name).write_text(text, encoding="utf-8", errors="surrogateescape")
    with pytest.raises(ValueError, match=sentence) as caught:
        control_point_files.read(tmp_path / name)
    assert len(str(caught.value)) < len(str(tmp_path)) + 200


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"there is no file `.*x\.csv`"):
        control_point_files.read(tmp_path / "x.csv")


def test_a_source_reads_files(tmp_path, messages):
    source = MLSControlPoints()
    source.SetMode("file")
    assert not source.GetExecutive().Update()
    messages.assert_one("`FileName` must name a file with control points: choose one")
    source.SetFileName(str(tmp_path / "x.csv"))
    assert not source.GetExecutive().Update()
    messages.assert_one("`FileName`: there is no file")
    control_point_files.write(tmp_path / "x.csv", REST, DEFORMED, [1.0, 2.0])
    p, q, w = arrays.control_points(update(source), "Displacement", "Weight")
    np.testing.assert_array_equal(p, REST)
    np.testing.assert_allclose(q, DEFORMED, rtol=1e-15)
    assert w.tolist() == [1, 2]

    control_point_files.write(tmp_path / "q.fcsv", REST, REST + 1)
    source.SetDeformedFileName(str(tmp_path / "q.fcsv"))
    _, q, _ = arrays.control_points(update(source), "Displacement")
    np.testing.assert_allclose(q, REST + 1)
    source.SetDeformedPoints(REST + 2)
    source.SetWeights([3.0, 4.0])
    _, q, w = arrays.control_points(update(source), "Displacement", "Weight")
    np.testing.assert_allclose(q, REST + 2)
    assert w.tolist() == [3, 4]

    control_point_files.write(tmp_path / "q.fcsv", REST[:1], REST[:1])
    source.Modified()
    assert not source.GetExecutive().Update()
    messages.assert_one(r"q\.fcsv` must hold one position for each of the 2 .*x\.csv`, got 1")
