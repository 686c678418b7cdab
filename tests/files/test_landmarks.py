"""Two files of points make pairs; names of points go along."""

import json

import numpy as np
import pytest
from pipelines import control_points, update
from vtk_fixtures import DEFORMED, REST
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

from vtk_mls import io
from vtk_mls.commands.cli import main
from vtk_mls.files import control_point_files
from vtk_mls.files.landmarks import Landmarks, paired
from vtk_mls.filters import MLSControlPoints
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

NOWHERE = (np.nan,) * 3


def _points(path, labels, places=None, **more):
    """Points at (1, 0, 0), (2, 0, 0), ..., or at these places."""
    if places is None:
        places = [(i + 1.0, 0.0, 0.0) for i in range(len(labels))]
    return Landmarks(path, np.array(places, float).reshape(-1, 3), "LPS", labels, **more)


def _pairs(*points):
    found = paired(*points)
    return list(zip(found.labels, found.rest[:, 0].tolist(), found.deformed[:, 0].tolist()))


@pytest.mark.parametrize(
    ("pair_by", "rest", "deformed", "expected"),
    [
        ("", "abc", "cab", "a2 b3 c1"),
        ("", "abc", ["", "", ""], "a1 b2 c3"),
        ("", "abc", "aac", "a1 b2 c3"),
        ("", ["", "", ""], "abc", "1 2 3"),
        ("", ["rest-1", "rest-2"], ["moved - x-2", "moved - x-1"], "rest-12 rest-21"),
        ("", ["1", "2", "3"], ["F-2", "F-1", "F-3"], "12 21 33"),
        ("order", "ab", "ba", "a1 b2"),
        ("labels", "ab", "ba", "a2 b1"),
        ("labels", ["p-1", "p-2"], ["q-2", "q-1"], "p-12 p-21"),
        ("common", "abcd", "xdb", "b3 d2"),
    ],
)
def test_how_points_make_pairs(pair_by, rest, deformed, expected, caplog):
    """Expected are the label of p and the number of q."""
    found = _pairs(_points("p", rest), _points("q", deformed), (), pair_by)
    assert " ".join(f"{label}{q:g}" for label, _, q in found) == expected
    assert [p for _, p, _ in found] == ([2, 4] if len(rest) == 4 else [*range(1, len(rest) + 1)])
    left_out = "points without a partner are left out: only `p` has `a`, `c`; only `q` has `x`"
    by_order = "points are paired by their order, not by labels, for `q` has `a` 2 times"
    assert caplog.messages == [left_out] * (len(rest) == 4) + [by_order] * (deformed == "aac")


@pytest.mark.parametrize(
    ("pair_by", "rest", "deformed", "sentence"),
    [
        ("", "abc", "abd", r"labels of `p` and `q` do not fit: only `p` .* `c`; only `q` has `d`$"),
        ("", "a", "abcdefghi", r"only `q` has `b`, `c`, `d`, `e`, `f` and 3 more$"),
        ("", ["T1", "T2"], ["L1", "L2"], r"only `p` has `T1`, `T2`; only `q` has `L1`, `L2`$"),
        ("", ["T-1", "T-2"], ["L-1", "L-3"], r"only `p` has `T-1`, `T-2`; only `q` has `L-1`, `L"),
        ("", ["T-1", "T-01"], ["L-1", "L-2"], r"only `p` has `T-1`, `T-01`; only `q` has"),
        ("", ["T-1", "U-2"], ["L-1", "L-2"], r"only `p` has `T-1`, `U-2`; only `q` has"),
        ("", "aab", "ab", r"`q` must hold .* the 3 control .* of `p`, got 2$"),
        ("", ["", ""], "abc", r"`q` must hold one position for each of the 2 control .*, got 3$"),
        ("order", "abc", "ab", r"`q` must hold one position for each of the 3 .* of `p`, got 2$"),
        ("labels", "abc", "ab", r"do not fit: only `p` has `c`$"),
        ("labels", "ab", ["", "a"], r"must have its own label; `q` has 1 points without a label$"),
        ("common", "aab", "ab", r"each point must have its own label; `p` has `a` 2 times$"),
        ("common", "ab", "cd", r"^`p` and `q` have no label in common: the first has `a`, `b`"),
    ],
)
def test_what_makes_no_pairs(pair_by, rest, deformed, sentence):
    with pytest.raises(ValueError, match=sentence):
        paired(_points("p", rest), _points("q", deformed), (), pair_by)


def test_the_option_sets_how_points_make_pairs(files, refused, caplog):
    files.joinpath("p.csv").write_text("a,0,0,0\nb,9,0,0\nc,0,9,0\n")
    files.joinpath("q.csv").write_text("c,0,9,1\na,1,0,0\n")
    (files / "two.csv").write_text("a,0,0,0\nc,0,9,0\n")
    arguments = ["two.csv", "p.csv", "out.csv", "--deformed", "q.csv"]
    assert "only `p.csv` has `b`" in refused("points", *arguments)
    assert main(["points", *arguments, "--pair-by", "common"]) == 0
    assert caplog.messages == ["points without a partner are left out: only `p.csv` has `b`"]
    found = control_point_files.read_landmarks("out.csv").positions
    np.testing.assert_allclose(found, [(1, 0, 0), (0, 9, 1)], atol=1e-6)
    for command in (["points", "p.csv", "p.csv", "o.csv"], ["check", "p.csv"]):
        assert "name the second by --deformed" in refused(*command, "--pair-by", "order")


def test_points_of_vtk_files_are_landmarks(files):
    io.write_handles("in.vtp", REST, REST)
    arguments = ["points", "in.vtp", "handles.csv", "out.csv"]
    assert main(arguments) == 0
    found = control_point_files.read_landmarks("out.csv").positions
    np.testing.assert_allclose(found, DEFORMED, atol=1e-6)


def test_a_point_that_is_not_placed_goes_with_its_partner():
    one = [(1, 0, 0), NOWHERE, (3, 0, 0), (4, 0, 0)]
    other = [(1, 0, 0), (2, 0, 0), (3, 0, 0), NOWHERE]
    weights = np.array([1.0, 2, 3, 4])
    for labels in ("abcd", ["", "", "", ""]):
        rest = _points("p", labels, one, weights=weights)
        found = paired(rest, _points("q", labels, other))
        assert found.rest[:, 0].tolist() == found.deformed[:, 0].tolist() == [1, 3]
        assert found.weights.tolist() == [1, 3]
    found = _pairs(_points("p", "abcd", one), _points("q", "dcba", other))
    assert found == [("c", 3, 2), ("d", 4, 1)]
    with pytest.raises(ValueError, match=r"^`p` holds no control points, nor pairs with .* `q`: "):
        paired(_points("p", "ab", one[:2]), _points("q", "ab", other[:1:-1]))
    with pytest.raises(ValueError, match=r"^`p` holds no control points: none is placed$"):
        paired(_points("p", "a", [NOWHERE]))


def test_a_second_file_of_pairs_must_not_have_two_positions():
    rest, places = _points("p", "a"), np.array([(5.0, 0, 0)])
    both = _points("q", "a", [(4, 0, 0)], partners=places)
    with pytest.raises(ValueError, match=r"^`q` has two positions for a point; a file of"):
        paired(rest, both)
    assert _pairs(rest, _points("q", "a", places, partners=places)) == [("a", 1, 5)]
    assert _pairs(both, rest) == [("a", 4, 1)]


def _write_markups(path, places, labels, frame="LPS", **more):
    places = np.array(places) * {"LPS": 1, "RAS": (-1, -1, 1)}[frame]
    points = [{"label": a, "position": place} for a, place in zip(labels, places.tolist())]
    points[0] |= more
    markups = {"type": "Fiducial", "coordinateSystem": frame, "controlPoints": points}
    path.write_text(json.dumps({"markups": [markups]}))


@pytest.fixture
def dragged(files):
    """The control points of handles.csv as two files whose points are in different orders."""
    labels = list("abcdefgh")
    _write_markups(files / "rest.mrk.json", REST, labels)
    _write_markups(files / "q.mrk.json", DEFORMED[::-1], labels[::-1], "RAS")
    return files


@pytest.mark.parametrize("rest", ["rest.mrk.json", "rest.vtp", "handles.csv", "ras.txt"])
def test_the_command_takes_places_from_a_second_file(dragged, rest, capsys):
    options = []
    if rest == "rest.vtp":
        polydata = io.read_control_points("rest.mrk.json")
        configured(vtkXMLPolyDataWriter(), InputData=polydata, FileName=rest).Write()
        options += ["--handles-space", "ras"]  # the file says LPS
    if rest == "handles.csv":  # whose own q do not count; it has no labels
        (dragged / "q.mrk.json").unlink()
        _write_markups(dragged / "q.mrk.json", DEFORMED, "abcdefgh")
        np.savetxt(rest, np.hstack([REST, REST + 1]), delimiter=",", fmt="%.17g")
    if rest == "ras.txt":
        labelled = [f"{n},{-x!r},{-y!r},{z!r}\n" for n, (x, y, z) in zip("abcdefgh", REST.tolist())]
        (dragged / rest).write_text("".join(labelled))
        options += ["--handles-space", "ras"]
    assert main(["deform", "in.vti", rest, "out.vti", "--deformed", "q.mrk.json", *options]) == 0
    np.savetxt("one.csv", np.hstack([REST, DEFORMED]), delimiter=",", fmt="%.17g")
    options = ["--kind", "auto"]  # the default for marked pairs
    assert main(["deform", "in.vti", "one.csv", "expected.vti", *options]) == 0
    values = [
        arrays.to_numpy(io.read_dataset(name).GetPointData().GetArray("values"))
        for name in ("out.vti", "expected.vti")
    ]
    np.testing.assert_allclose(*values, atol=1e-5)
    assert np.ptp(values[0]) > 0


def test_handles_far_from_the_data_name_all_files(dragged, refused):
    control_point_files.write("far.fcsv", REST, REST + 1e12, None, list("abcdefgh"))
    options = ["--deformed", "far.fcsv"]
    error = refused("deform", "in.vti", "rest.mrk.json", "out.vti", *options)
    assert error.startswith("`rest.mrk.json` and `far.fcsv` must be where the data are")


def test_a_source_pairs_by_label_and_keeps_the_labels(dragged, messages, tmp_path):
    source = configured(MLSControlPoints(), Mode="file", FileName="rest.mrk.json")
    found = update(configured(source, DeformedFileName="q.mrk.json"))
    p, q, _ = arrays.control_points(found, "Displacement")
    np.testing.assert_array_equal(p, REST)
    np.testing.assert_allclose(q, DEFORMED, rtol=1e-15)
    assert arrays.texts(found.GetPointData(), "Label") == list("abcdefgh")
    for port in range(2):
        assert arrays.texts(source.GetOutputDataObject(port).GetFieldData(), "Space") == ["LPS"]

    # through a file and back
    path = str(tmp_path / "x.vtp")
    configured(vtkXMLPolyDataWriter(), InputData=found, FileName=path).Write()
    read = update(configured(vtkXMLPolyDataReader(), FileName=path))
    assert arrays.texts(read.GetPointData(), "Label") == list("abcdefgh")
    assert io.read_landmarks(tmp_path / "x.vtp").labels == list("abcdefgh")

    # an undefined point takes its pair along
    _write_markups(dragged / "rest.mrk.json", REST, "abcdefgh", positionStatus="undefined")
    source.Modified()
    found = update(source)
    assert arrays.texts(found.GetPointData(), "Label") == list("bcdefgh")
    _, q, _ = arrays.control_points(found, "Displacement")
    np.testing.assert_allclose(q, DEFORMED[1:], rtol=1e-15)
    messages.assert_one(r"only one of `rest.mrk.json` and `q.mrk.json` are left out: `a`$")

    _write_markups(dragged / "rest.mrk.json", REST, "abcdefgX")
    source.Modified()
    assert not source.GetExecutive().Update()
    messages.assert_one(r"rest\.mrk\.json` has `X`; only `.*q\.mrk\.json` has `h`")


def test_a_source_reads_files(tmp_path, messages):
    source = MLSControlPoints()
    source.SetMode("file")
    assert not source.GetExecutive().Update()
    messages.assert_one("`FileName` must name a file with control points: choose one")
    source.SetFileName(str(tmp_path / "x.csv"))
    assert not source.GetExecutive().Update()
    messages.assert_one("`FileName`: there is no file")
    control_point_files.write(tmp_path / "x.csv", REST, DEFORMED, [1.0] * 8)
    np.testing.assert_array_equal(arrays.control_points(update(source), "Displacement")[0], REST)
    control_point_files.write(tmp_path / "q.fcsv", REST[1:], REST[1:])
    source.SetDeformedFileName(str(tmp_path / "q.fcsv"))
    assert not source.GetExecutive().Update()
    messages.assert_one(r"q\.fcsv` must hold one position for each of the 8 .*x\.csv`, got 7")
    control_point_files.write(tmp_path / "q.fcsv", REST, REST + 1)
    source.Modified()
    source.SetDeformedPoints(REST + 2)
    source.SetWeights([3.0] * 8)
    _, q, w = arrays.control_points(update(source), "Displacement", "Weight")
    np.testing.assert_allclose(q, REST + 2)
    assert w.tolist() == [3] * 8


def test_a_source_has_the_frame(tmp_path, messages):
    source = MLSControlPoints()
    assert source.GetSpace() == "lps"
    source.SetRestPoints([(1, 2, 3)])
    source.SetSpace("ras")  # lists are as they are
    assert update(source).GetPoint(0) == (1, 2, 3)
    assert not arrays.texts(source.GetOutput().GetFieldData(), "Space")

    (tmp_path / "x.csv").write_text("1,2,3,5,5,5\n")
    source.SetMode("file")
    source.SetFileName(str(tmp_path / "x.csv"))
    for space, sign in (("ras", -1), ("lps", 1)):
        source.SetSpace(space)
        found = update(source)
        assert found.GetPoint(0) == (sign, 2 * sign, 3)
        (moved,) = arrays.to_numpy(found.GetPointData().GetArray("Displacement")).tolist()
        assert moved == [4 * sign, 3 * sign, 2]
        assert arrays.texts(found.GetFieldData(), "Space") == ["LPS"]
    control_point_files.write(tmp_path / "x.fcsv", [(1, 2, 3)], [(1, 2, 3)])
    source.SetFileName(str(tmp_path / "x.fcsv"))
    source.SetSpace("ras")  # the file says LPS
    assert update(source).GetPoint(0) == (1, 2, 3)
    source.SetSpace("xyz")
    assert not source.GetExecutive().Update()
    messages.assert_one("`Space` must be one of lps, ras, got 'xyz'")


@pytest.mark.parametrize(
    ("field", "frame", "sign"),
    [("Space", "LPS", 1), ("Space", "RAS", -1), ("FileSpace", "RAS", 1), ("Other", "RAS", -1)],
)
def test_polydata_carry_their_frame(tmp_path, field, frame, sign):
    polydata = update(control_points())
    arrays.add_texts(polydata.GetFieldData(), field, [frame])
    path = str(tmp_path / "x.vtp")
    configured(vtkXMLPolyDataWriter(), InputData=polydata, FileName=path).Write()
    found = io.read_control_points(path, space="RAS")  # counts if there is no Space
    p, q, _ = arrays.control_points(found, "Displacement")
    np.testing.assert_array_equal(p, REST * [sign, sign, 1])
    np.testing.assert_allclose(q, DEFORMED * [sign, sign, 1], rtol=1e-15)
