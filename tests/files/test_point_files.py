"""Landmarks and control points as other programs write them, and broken ones."""

import json

import numpy as np
import pytest
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints, vtkStringArray
from vtkmodules.vtkIOMINC import vtkMNITagPointReader, vtkMNITagPointWriter

from vtk_mls.files import control_point_files, formats
from vtk_mls.files.landmarks import Landmarks
from vtk_mls.vtk import arrays

BIGWARP = (  # as BigWarp writes it, a point that is still to be set among them
    '"Pt-0","true","1.5","2.0","3.0","4.0","5.0","6.0"\n'
    '"Pt #1","false","Infinity","Infinity","Infinity","7.0","8.0","9.0"\n'
    '"Pt-2","true","-1.0","-2.0","-3.0","1.0e-3","0.0","0.0"\n'
)
# As Slicer 5 exports tables; the last point is not placed.
SLICER = (
    '"label","l","p","s","defined","selected","visible","locked","description"\n'
    '"nose, tip",1,2,3,1,1,1,0,"a # b"\n"",4,5,6,0,1,1,0,""\n'
)
ANTS = "x,y,z,t,label,comment\n82.5,116.5,0,0,1,this is the breast\n137.5,35.5,1,0,2,nan\n"
ELASTIX = "point\n2\n102.8 -33.4 57.0\n1e1 2 3\n"
TRANSFORMIX = (  # as elastix 5 writes it
    "Point\t0\t; InputIndex = [ 1 2 3 ]\t; InputPoint = [ 0.500000 0.500000 0.500000 ]"
    "\t; OutputIndexFixed = [ 1 2 4 ]\t; OutputPoint = [ 1.500000 2.500000 -3.500000 ]"
    "\t; Deformation = [ 1.000000 2.000000 -4.000000 ]\n"
    "Point\t1\t; InputIndex = [ 1 2 3 ]\t; InputPoint = [ 0.000000 0.000000 0.000000 ]"
    "\t; OutputIndexFixed = [ 1 2 4 ]\t; OutputPoint = [ 4.000000 5.000000 6.000000 ]"
    "\t; Deformation = [ 4.000000 5.000000 6.000000 ]\t; OutputIndexMoving = [ 4 5 6 ]\n"
)
IDAV = "Version 1.0\n3\nS000 1.5 2 3\nS001 9999 9999 9999\nleft eye -4 5e1 6.25\n"
MINC = (  # as the program register writes pairs; volume 2 is the moving one
    "MNI Tag Point File\nVolumes = 2;\n% register a.mnc b.mnc\n\nPoints =\n"
    ' 4 5 6 1 2 3 0 -1 -1 "nose; \\"tip\\""\n -4 5.5 6 -1 2 3 1 2 -1 "ear";\n'
)


def _read(tmp_path, text, name="x.csv", **options):
    (tmp_path / name).write_text(text, encoding="utf-8", errors="surrogateescape")
    return control_point_files.read_landmarks(tmp_path / name, **options)


@pytest.mark.parametrize("axes", ["l,p,s", "r,a,s"])
def test_tables_of_slicer_have_their_frame(tmp_path, axes):
    found = _read(tmp_path, SLICER.replace('"l","p","s"', axes), space="ras")
    sign = 1 if axes == "l,p,s" else -1
    assert found.positions[0].tolist() == [sign, 2 * sign, 3]
    assert found.is_placed.tolist() == [True, False]
    assert (found.labels, found.descriptions) == (["nose, tip", ""], ["a # b", ""])


def test_tables_of_ants(tmp_path):
    found = _read(tmp_path, ANTS)
    assert found.positions.tolist() == [[82.5, 116.5, 0], [137.5, 35.5, 1]]
    assert found.labels == ["1", "2"]
    assert found.descriptions == ["this is the breast", "nan"]


@pytest.mark.parametrize("name", ["x.txt", "x.pts", "x.csv"])
def test_points_of_elastix(tmp_path, name):
    found = _read(tmp_path, ELASTIX, name)
    assert found.positions.tolist() == [[102.8, -33.4, 57], [10, 2, 3]]
    assert found.labels == ["", ""]
    found = _read(tmp_path, TRANSFORMIX, name)
    assert found.positions.tolist() == [[1.5, 2.5, -3.5], [4, 5, 6]]
    assert found.labels == ["0", "1"]


def test_points_of_idav_landmark(tmp_path):
    found = _read(tmp_path, IDAV, "x.pts", space="ras")
    assert found.labels == ["S000", "S001", "left eye"]
    assert found.is_placed.tolist() == [True, False, True]
    assert found.positions[[0, 2]].tolist() == [[-1.5, -2, 3], [4, -50, 6.25]]


def test_tag_points_of_minc(tmp_path):
    """In RAS; the second volume is moved onto the first."""
    found = _read(tmp_path, MINC, "x.tag", space="lps")
    assert found.labels == ['nose; "tip"', "ear"]
    assert found.positions.tolist() == [[-1, -2, 3], [1, -2, 3]]
    assert found.partners.tolist() == [[-4, -5, 6], [4, -5.5, 6]]
    found = _read(tmp_path, "MNI Tag Point File\nVolumes = 1;\nPoints = 1 2 3;\n", "x.tag")
    assert (found.positions.tolist(), found.partners) == ([[-1, -2, 3]], None)


@pytest.mark.parametrize("labels", [["a", 'b; "c" \\'], ["", ""]])
@pytest.mark.parametrize("weights", [None, [0.5, 2.0]])
def test_tag_points_are_those_of_vtk(tmp_path, labels, weights):
    """VTK's writer and reader, which keep MINC's frame."""
    rest, deformed = np.array([(1.5, 2, 3), (4, 5, 6)]), np.array([(1, 2, 3.25), (-7, 8, 9)])
    path, names = tmp_path / "x.tag", vtkStringArray()
    for label in labels:
        names.InsertNextValue(label)
    writer = vtkMNITagPointWriter()
    for volume, places in enumerate((deformed, rest)):
        points = vtkPoints()
        points.SetData(arrays.from_numpy(places * (-1, -1, 1), VTK_DOUBLE))
        writer.SetPoints(volume, points)
    writer.SetLabelText(names if labels[0] else None)
    writer.SetWeights(weights and arrays.from_numpy(np.array(weights), VTK_DOUBLE))
    writer.SetFileName(str(path))
    writer.Write()
    found = control_point_files.read_pairs(path, space="ras")
    assert (found.rest.tolist(), found.deformed.tolist()) == (rest.tolist(), deformed.tolist())
    assert (found.labels, found.weights) == (labels, None)
    control_point_files.write(path, rest, deformed, weights, labels)
    reader = vtkMNITagPointReader()
    reader.SetFileName(str(path))
    reader.Update()
    for volume, places in enumerate((deformed, rest)):
        own = arrays.to_numpy(reader.GetPoints(volume).GetData())
        np.testing.assert_array_equal(own, places * (-1, -1, 1))
    read = reader.GetLabelText()
    count = 0 if read is None else read.GetNumberOfValues()
    assert [read.GetValue(i) for i in range(count)] == [label for label in labels if label]


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("1,2,3\n4,5,6\n", ["", ""]),
        ("# x y z\n1 2\t3\n\n4 5 6 # last\n", ["", ""]),
        ("a,1,2,3\nb,4,5,6", ["a", "b"]),
        ("label,x,y,z\na,1,2,3\nb,4,5,6", ["a", "b"]),
        ("\ufeffZ,Y,X,Name\r\n3,2,1,a\r\n6,5,4,b\r\n", ["a", "b"]),
    ],
    ids=["plain", "blanks", "labels", "header", "order"],
)
def test_tables_of_places(tmp_path, text, labels):
    found = _read(tmp_path, text)
    assert found.positions.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert (found.labels, found.partners) == (labels, None)


def test_the_header_has_the_order_and_the_labels_of_control_points(tmp_path):
    found = _read(tmp_path, "qx,qy,qz,label,px,py,pz\n4,5,6,a,1,2,3\n")
    assert (found.positions.tolist(), found.partners.tolist()) == ([[1, 2, 3]], [[4, 5, 6]])
    assert found.labels == ["a"]
    found = _read(tmp_path, "a,1,2,3,4,5,6,7\n")
    assert (found.partners.tolist(), found.weights.tolist()) == ([[4, 5, 6]], [7])


@pytest.mark.parametrize("suffix", [*formats.endings(reads=(formats.POINTS,)), ".TXT"])
@pytest.mark.parametrize("weights", [None, [2.0, 0.1]])
def test_control_points_and_their_labels_are_written(tmp_path, suffix, weights):
    path, labels = tmp_path / f"x{suffix}", ["nose #1", 'a, "b"']
    rest = np.array([(1.25, -2, 3e-9), (4e5, 5, 6)])
    deformed = rest + [(0.5, 0, 0), (0, 1e-3, 0)]
    control_point_files.write(path, rest, deformed, weights, labels)
    found = control_point_files.read_pairs(path)
    has_pairs = formats.find(path, writes=(formats.PAIRS,)) is not None
    np.testing.assert_array_equal(found.rest, rest if has_pairs else deformed)
    np.testing.assert_array_equal(found.deformed, deformed)
    assert found.labels == (["", ""] if suffix == ".pts" else labels)
    if suffix in (".csv", ".txt", ".TXT") and weights:
        assert found.weights.tolist() == weights
    else:
        assert found.weights is None


def test_a_table_by_paraview_keeps_its_labels(tmp_path):
    names = [f'"{name}:{axis}"' for name in ("Displacement", "Points") for axis in range(3)]
    found = _read(tmp_path, f'{",".join(names)},"Label"\n1,0,0,1,2,3,"a, b"\n')
    assert (found.partners.tolist(), found.labels) == ([[2, 2, 3]], ["a, b"])


def test_all_markups_of_a_file_are_read_each_in_its_frame(tmp_path):
    def point(label, position, **more):
        return {"label": label, "position": position, **more}

    markups = [
        {"type": "Fiducial", "controlPoints": [point("a", [1, 2, 3], description="tip")]},
        {"type": "ROI"},
        {
            "type": "ClosedCurve",
            "coordinateSystem": "RAS",
            "controlPoints": [
                point("b", [1, 2, 3], orientation=[9] * 9),
                point("c", "", positionStatus="undefined"),
                point("d", [0, 0, 0], positionStatus="preview"),
                point("e", [0, 0, 0], positionStatus="missing"),
                {"label": "f"},
            ],
        },
    ]
    found = _read(tmp_path, json.dumps({"markups": markups}), "x.mrk.json")
    assert found.labels == list("abcdef")
    assert found.positions[:2].tolist() == [[1, 2, 3], [-1, -2, 3]]
    assert found.is_placed.tolist() == [True, True, False, False, False, False]
    assert found.descriptions[0] == "tip"


@pytest.mark.parametrize(("system", "sign"), [("LPS", 1), ("1", 1), ("RAS", -1), ("0", -1)])
def test_fiducials_of_old_and_new_slicers(tmp_path, system, sign):
    old = "# Fiducial List file /a\n# columns = label,x,y,z,sel,vis\nleft eye,1,2,3,1,1\n"
    found = _read(tmp_path, old, "x.fcsv")
    assert (found.labels, found.positions.tolist()) == (["left eye"], [[-1, -2, 3]])
    new = (
        f"# Markups fiducial file version = 5.6\n# CoordinateSystem = {system}\n"
        '1,1,2,3,0,0,0,1,1,1,0,"a, b","of two\nlines",,2,0\n2,7,8,9,0,0,0,1,1,1,0,c,,,0,0\n'
    )
    found = _read(tmp_path, new, "x.fcsv")
    assert found.positions[0].tolist() == [sign, 2 * sign, 3]
    assert (found.labels, found.descriptions) == (["a, b", "c"], ["of two\nlines", ""])
    assert found.is_placed.tolist() == [True, False]


@pytest.mark.parametrize(
    "text",
    ["1,5;2;3;4;5;-6,25\n", "px;py;pz;qx;qy;qz\n1,5;2,0;3;4;5;-6,25\n", "a;1,5;2;3;4;5;-6.25\n"],
)
def test_a_table_with_semicolons_may_have_decimal_commas(tmp_path, text):
    found = _read(tmp_path, text)
    assert found.positions.tolist() == [[1.5, 2, 3]]
    assert found.partners.tolist() == [[4, 5, -6.25]]


def test_semicolons_in_a_label_separate_nothing(tmp_path):
    assert _read(tmp_path, "a;b;c,1,2,3,4,5,6\n").positions.tolist() == [[1, 2, 3]]


def test_markups_are_written_for_older_slicers(tmp_path):
    control_point_files.write(tmp_path / "x.fcsv", [[1, 2, 3]], [[1, 2, 3]], None, ["a\nb"])
    lines = (tmp_path / "x.fcsv").read_text().splitlines()
    assert lines[1] == "# CoordinateSystem = 1"  # versions before 4.11 read a number
    assert lines[3] == "1,1.0,2.0,3.0,0,0,0,1,1,1,0,a b,,"
    control_point_files.write(tmp_path / "x.mrk.json", [[1, 2, 3]], [[1, 2, 3]])
    schema = json.loads((tmp_path / "x.mrk.json").read_text())["@schema"]
    folder = "Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#"
    assert schema == f"https://raw.githubusercontent.com/slicer/slicer/master/{folder}"


@pytest.mark.parametrize("space", ["lps", "ras"])
def test_the_frame_of_files_that_do_not_state_one(tmp_path, space):
    sign = {"lps": 1, "ras": -1}[space]
    for text in (ELASTIX, ANTS, "1,2,3\n", BIGWARP, TRANSFORMIX):
        expected = _read(tmp_path, text).positions * [sign, sign, 1]
        np.testing.assert_array_equal(_read(tmp_path, text, space=space).positions, expected)
    control_point_files.write(tmp_path / "x.csv", [[1, 2, 3]], [[4, 5, 6]])
    rest, deformed, *_ = control_point_files.read_pairs(tmp_path / "x.csv", space=space)
    assert rest.tolist() == [[sign, 2 * sign, 3]]
    assert deformed.tolist() == [[4 * sign, 5 * sign, 6]]
    for suffix in (".fcsv", ".mrk.json"):
        control_point_files.write(tmp_path / f"x{suffix}", [[1, 2, 3]], [[4, 5, 6]])
        rest, *_ = control_point_files.read_pairs(tmp_path / f"x{suffix}", space=space)
        assert rest.tolist() == [[4, 5, 6]]


NOWHERE = np.full(3, np.nan)


def test_markups_with_other_places_keep_all_else(tmp_path):
    point = {"id": "7", "label": "a [1  2]", "position": [1, 2, 3], "locked": True, "color": [1, 2]}
    curve = {"type": "Curve", "display": {"opacity": 0.5}, "controlPoints": [point, dict(point)]}
    curve |= {"measurements": [{"name": "length", "value": 2}]}
    plane = {"type": "Plane", "coordinateSystem": "RAS", "center": [1, 2, 3], "name": "cut"}
    plane["controlPoints"] = [dict(point)]
    text = json.dumps({"@schema": "markups-schema-v1.0.0.json", "markups": [curve, plane]})
    points = _read(tmp_path, text, "x.mrk.json")
    moved = Landmarks("", np.array([(7.0, 8, 9), NOWHERE, (7, 8, 9)]), "LPS", points.labels)
    path = tmp_path / "y.mrk.json"
    assert control_point_files.write_landmarks(path, moved, tmp_path / "x.mrk.json") == 0
    found = json.loads(path.read_text())
    assert found["@schema"] == "markups-schema-v1.0.0.json"
    undefined = {key: value for key, value in point.items() if key != "position"}
    undefined["positionStatus"] = "undefined"
    assert found["markups"] == [
        {
            "type": "Curve",
            "display": {"opacity": 0.5},
            "controlPoints": [point | {"position": [7, 8, 9]}, undefined],
        },
        {
            "type": "Fiducial",
            "coordinateSystem": "RAS",
            "name": "cut",
            "controlPoints": [point | {"position": [-7, -8, 9]}],
        },
    ]


@pytest.mark.parametrize("suffix", formats.endings(reads=(formats.POINTS,)))
@pytest.mark.parametrize("space", ["lps", "ras"])
def test_landmarks_from_one_format_to_another(tmp_path, suffix, space):
    places = np.array([(1.25, -2, 3e-9), NOWHERE, (4e5, 5, 6)])
    points = Landmarks("", places, "LPS", ["a", "b", "c, d"], ["one", "", "three"])
    path = tmp_path / f"x{suffix}"
    left_out = control_point_files.write_landmarks(path, points, tmp_path / "y.vtp", space)
    found = control_point_files.read_landmarks(path, space)
    rows = slice(None) if suffix == ".mrk.json" else [0, 2]
    np.testing.assert_array_equal(found.positions, places[rows])
    assert left_out == 3 - len(found.positions)
    if suffix not in (".txt", ".pts"):
        assert found.labels == np.array(points.labels)[rows].tolist()
    if suffix not in (".txt", ".pts", ".tag"):
        assert found.descriptions == np.array(points.descriptions)[rows].tolist()


@pytest.mark.parametrize("name", ["x.csv", "x.txt"])
def test_a_table_of_positions_alone_stays_one(tmp_path, name):
    points = _read(tmp_path, "1 2 3\n4 5 6\n", name, space="ras")
    assert control_point_files.write_landmarks(tmp_path / name, points, tmp_path / name) == 0
    assert (tmp_path / name).read_text() == "x,y,z\n-1.0,-2.0,3.0\n-4.0,-5.0,6.0\n"


def _markups(point, **more):
    return json.dumps({"markups": [{"controlPoints": [point], **more}]})


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("x.csv", "px,py,pz\n", r"` holds no control points"),
        ("x.csv", 10**6 * "1,", r"`, line 1: expected numbers .*1,\.\.\.` of 2000000 char"),
        ("x.csv", "1,2,3,4,5,inf\n", r"` has a coordinate that is not a finite number"),
        ("x.csv", "1,2,3,4,5,6,-1\n", r"` has a weight that is not a positive number"),
        ("x.csv", "9" * 200_000, r"`, line 1: field larger than field limit"),
        ("x.csv", "1,\udcff", r"` is not UTF-8 text: its byte 2 is 255"),
        ("x.csv", "x,y,label\n1,2,3\n", r"`, line 1: the columns `x,y,label` are not known; name"),
        ("x.csv", "x,y,z,x\n1,2,3,4\n", r"`, line 1: several columns are x$"),
        ("x.csv", "r,a,s\n1,2,3\n1,2\n", r"line 3: expected 3 cells .* numbers in r, a, s, got"),
        ("x.csv", "r,a,s\n1,2,three\n", r"line 2: expected 3 cells .* got `1,2,three`$"),
        ("x.csv", "x,y,z,defined\n1,2,inf,1\n", r"` has a coordinate .* finite number in line 2$"),
        ("x.csv", "x,y,z,weight\n1,2,3,0\n", r"` has a weight that is not a positive number"),
        ("x.csv", "1,2,3\na,4,5,6\n", r"`, line 2: expected numbers x,y,z, as many in each line"),
        ("x.csv", "1,2,3\n1_0,5,6\n", r"`, line 2: expected numbers x,y,z, as many in each line"),
        ("x.csv", "1,2,3,4\n", r"`, line 1: expected numbers px,.* got `1,2,3,4`; name the col"),
        ("x.csv", "1;2\n1;2\n", r"`, line 1: the columns `1;2` are not known"),
        ("x.txt", "1 2 3\n4 5,0 6\n", r"`, line 2: expected numbers x,y,z, .* got `4 5,0 6`$"),
        ("x.csv", BIGWARP.replace("true", "yes"), r"`, line 1: expected numbers px"),
        ("x.csv", BIGWARP + '"p","yes",1,2,3,4,5,6', r"line 4: expected name,active,x,y,z,u,v,w"),
        ("x.csv", BIGWARP.replace("false", "true"), r"not a finite number in line 2$"),
        ("x.csv", '"p","true","1","2","3","4"\n', r"line 1: .* BigWarp in two dimensions; it must"),
        ("x.txt", "index\n1\n1 2 3\n", r"` holds indices of voxels; expected positions, after"),
        ("x.txt", "point\n", r"`, line 2: expected the number of points, got ``$"),
        ("x.txt", "point\n2\n1 2 3\n", r"` must hold 2 points, as it says, got 1$"),
        ("x.txt", "point\n-1\n1 2 3\n", r"`, line 2: expected the number of points, got `-1"),
        ("x.txt", "point\n1\n1 2\n", r"`, line 3: expected three numbers, got `1 2"),
        ("x.txt", "point\n1\n1 2 nan\n", r"` has a coordinate .* finite number in line 3$"),
        ("x.txt", "point\n0\n", r"` holds no control points"),
        ("x.txt", TRANSFORMIX + "Point 2 ;\n", r"`, line 3: expected `Point N ; .* got `Point 2 ;"),
        ("x.txt", TRANSFORMIX[:-120], r"`, line 2: expected `Point N ; \.\.\. OutputPoint"),
        ("x.pts", IDAV.replace("3\n", "4\n", 1), r"` must hold 4 points, as it says, got 3$"),
        ("x.pts", "Version 1.0\n1\na 1 nan 2\n", r"` has a coordinate .* finite number in line 3$"),
        ("x.pts", "Version 1.0\n1\n1 2 3\n", r"`, line 3: expected a label and three .* `1 2 3`$"),
        ("x.tag", MINC[4:], r"` does not begin with `MNI Tag Point File`$"),
        ("x.tag", MINC.replace("= 2", "= 3"), r"` must have a line `Volumes = 1;` or 2, and then"),
        ("x.tag", MINC.partition("Points")[0], r"` must have a line .*, and then `Points =`$"),
        ("x.tag", MINC.replace("= 2", "= 1"), r"line 6: expected 3 coordinates, .* got `4 5 6 1"),
        ("x.tag", MINC.replace("0 -1 -1", "0 -1"), r"line 6: expected 6 coordinates, perhaps thr"),
        ("x.tag", MINC.replace("4 5 6", "4 5 nan"), r"coordinate .* not a finite .* in line 6$"),
        ("x.tag", MINC.rpartition(";")[0], r"` is cut off: a semicolon must follow its last"),
        ("x.tag", MINC + "1 2 3 1 2 3;\n", r"line 8: expected 6 coordinates"),
        ("x.fcsv", "# nothing\n", r"` holds no control points"),
        ("x.fcsv", "a,1,2\n", r"` has a position that is not three numbers"),
        ("x.fcsv", "a,1,2,nan", r"` has a coordinate that is not a finite number"),
        ("x.fcsv", "# CoordinateSystem = lps\na,1,2,3\n", r"` has the coordinate system lps; it"),
        ("x.fcsv", "#\n\na,1,2,3\na,1,x,3\n", r"not three numbers in line 4: `a,1,x,3`$"),
        ("x.fcsv", 'a,1,2,3,"\n' + 200_000 * "9", r"`, line 2: field larger than field limit"),
        ("x.json", "{}", r"must end in one of .*\.mrk\.json"),
        ("x.mrk.json", "{", r"` has no markups"),
        ("x.mrk.json", "[" * 100_000, r"` has no markups: it is nested too"),
        ("x.mrk.json", '"\udcff"', r"` is not UTF-8 text"),
        ("x.mrk.json", '{"markups": 5}', r"` has no markups: TypeError\('`markups` is not"),
        ("x.mrk.json", _markups(5), r"`controlPoints` is not a list of d"),
        ("x.mrk.json", _markups({}, coordinateSystem=["LPS"]), r"system \['LPS'\]; it"),
        ("x.mrk.json", _markups({"position": [1, 2, 10**400]}), r"that is not three numbers"),
        ("x.mrk.json", _markups({}, coordinateSystem="IJK"), r"has the coordinate system IJK; it"),
        ("x.mrk.json", _markups({"position": ["1", 2, 3]}), r"not three numbers: point 1 is at"),
        ("x.mrk.json", _markups({"position": [True, 2, 3]}), r"not three numbers: point 1 is at"),
        ("x.mrk.json", _markups({"position": [1, 2, float("nan")]}), r"finite number in point 1$"),
        ("x.mrk.json", _markups({"positionStatus": "lost"}), r"point 1: `positionStatus` must be "),
        ("x.mrk.json", _markups({"positionStatus": [1]}), r"must be one of .* got `\[1\]`$"),
    ],
)
def test_bad_files(tmp_path, name, text, sentence):
    with pytest.raises(ValueError, match=rf"x\..*{sentence}") as caught:
        _read(tmp_path, text, name)
    assert len(str(caught.value)) < len(str(tmp_path)) + 240
    assert "\n" not in str(caught.value)


def test_places_without_a_header_are_not_taken_for_control_points(tmp_path):
    for text in ("1,2,3\n", "a,1,2,3\n"):
        _read(tmp_path, text)
        with pytest.raises(ValueError, match=r"x\.csv`, line 1: expected numbers px,py,pz,qx"):
            control_point_files.read_pairs(tmp_path / "x.csv")
    _read(tmp_path, "x,y,z\n1,2,3\n")
    rest, deformed, *_ = control_point_files.read_pairs(tmp_path / "x.csv")
    assert rest.tolist() == deformed.tolist() == [[1, 2, 3]]


def test_labels_can_be_anything(tmp_path):
    labels = [None, 5, [1], "\ud800", "a\nb", "#"]
    points = [{"label": label, "position": [1, 2, 3]} for label in labels]
    text = json.dumps({"markups": [{"controlPoints": points}]})
    found = _read(tmp_path, text, "x.mrk.json")
    assert found.labels == ["", "5", "[1]", "?", "a\nb", "#"]
    for suffix in formats.endings(reads=(formats.POINTS,)):
        control_point_files.write_landmarks(tmp_path / f"y{suffix}", found)
        assert len(control_point_files.read_landmarks(tmp_path / f"y{suffix}").positions) == 6
