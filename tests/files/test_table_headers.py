"""The names in the first row of a table say which columns are p and q; other names are refused."""

import numpy as np
import pytest

from vtk_mls import io
from vtk_mls.files import control_point_files

REST = np.array([(40.5, 41.25, 42.5), (60.5, 40.5, 40.5), (40.5, 60.5, 40.25)])
DEFORMED = REST + [(3.5, 0, 0), (0, 1.25, 0), (0, 0, -2.5)]
ROWS = [",".join(map(repr, row)) for row in np.hstack([REST, DEFORMED]).tolist()]
ADVICE = "name the columns in a header, as in px,py,pz,qx,qy,qz or x,y,z,dx,dy,dz"


def _table(header, rows=ROWS):
    return "\n".join([header, *rows]) + "\n"


def _read(folder, text, name="x.csv", **options):
    (folder / name).write_text(text, encoding="utf-8")
    return control_point_files.read_pairs(folder / name, **options)


def _assert_pairs(found, rest=REST, deformed=DEFORMED):
    np.testing.assert_array_equal(found.rest, rest)
    np.testing.assert_allclose(found.deformed, deformed, rtol=1e-15)


@pytest.mark.parametrize(
    "header",
    [
        '"px","py","pz","qx","qy","qz"',
        "PX, PY, PZ, QX, QY, QZ",
        "\ufeffpx,py,pz,qx,qy,qz",
        "# px,py,pz,qx,qy,qz",
        "# made by hand\n# px py pz qx qy qz",
        "# px,py,pz,qx,qy,qz\npx,py,pz,qx,qy,qz",
        "x,y,z,qx,qy,qz",
        "",
    ],
)
def test_names_of_both_positions(tmp_path, header):
    _assert_pairs(_read(tmp_path, _table(header)))


@pytest.mark.parametrize(
    "header",
    [
        "x,y,z,dx,dy,dz",
        "# x y z dx dy dz",
        "px,py,pz,dx,dy,dz",
        '"Points:0","Points:1","Points:2","Displacement:0","Displacement:1","Displacement:2"',
        "Points_0,Points_1,Points_2,Displacement_0,Displacement_1,Displacement_2",
    ],
)
def test_displacements_are_added(tmp_path, header):
    _assert_pairs(_read(tmp_path, _table(header)), REST, REST + DEFORMED)


@pytest.mark.parametrize(
    "header",
    [
        "",
        '"Label","Use","X","Y","Z","X1","Y1","Z1"',
        '"Label","Use","X","Y","Z,"X1","Y1","Z1"',  # as flybrains has it
        "name,active,x_moving,y_moving,z_moving,x_fixed,y_fixed,z_fixed",
    ],
)
@pytest.mark.parametrize(("yes", "no"), [("true", "false"), ("True", "False")])
def test_landmarks_of_bigwarp(tmp_path, header, yes, no):
    infinite = ",".join(3 * ['"Infinity"'])
    rows = [f'"Pt-{i}","{yes}",{row}' for i, row in enumerate(ROWS)]
    rows += [f'"Pt-8","{no}",1,2,3,4,5,6', f'"Pt-9","{no}",{infinite},4,5,6']
    found = _read(tmp_path, _table(header, rows))
    _assert_pairs(found)
    assert found.labels == ["Pt-0", "Pt-1", "Pt-2"]


def test_positions_that_are_not_used_are_left_out(tmp_path):
    text = "use,x,y,z\ntrue,1,2,3\nfalse,4,5,6\n"
    assert _read(tmp_path, text).rest.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize("names", ["u,v,w", "x1,y1,z1", "new_x,new_y,new_z", "x_fixed,a,b"])
def test_unknown_columns_that_may_be_q_are_refused(tmp_path, names, caplog):
    sentence = rf"x\.csv`: the columns `{names}` are not known; {ADVICE}$"
    for header in (f"x,y,z,{names}", f"# x,y,z,{names}"):
        with pytest.raises(ValueError, match=sentence):
            _read(tmp_path, _table(header))
        with pytest.raises(ValueError, match=sentence):
            io.read_control_points(tmp_path / "x.csv")
    assert not caplog.records
    # positions of something else, or of a second file, are those of x, y and z
    found = control_point_files.read_landmarks(tmp_path / "x.csv")
    np.testing.assert_array_equal(found.positions, REST)
    assert f"the columns `{names}` are ignored" in caplog.text


@pytest.mark.parametrize(
    "header",
    [
        "x_moving,y_moving,z_moving,x_fixed,y_fixed,z_fixed",
        "x1,y1,z1,x2,y2,z2",
        "axis-0,axis-1,axis-2,a,b,c",  # z, y, x of napari
        "dx,dy,dz,a,b,c",
        "px,py,pz,qx,qy,q",
        "x,y,z,Displacement:0,Displacement:1,c",
    ],
)
@pytest.mark.parametrize("is_alone", [True, False])
def test_unknown_headers_are_refused(tmp_path, header, is_alone):
    (tmp_path / "x.csv").write_text(_table(header))
    with pytest.raises(ValueError, match=rf"line 1: the columns .* are not known; {ADVICE}$"):
        control_point_files.read_landmarks(tmp_path / "x.csv", is_alone=is_alone)


@pytest.mark.parametrize(
    "text",
    [
        "px,py,pz,qx,qy,qz\n0,1,2,3,4,5\n40,41,42,43,41,42\n",
        "# px py pz qx qy qz\n0,1,2,3,4,5\n40,41,42,43,41,42\n",
        "0.0,1.0,2.0,3.0,4.0,5.0\n40.5,41.5,42.5,43.5,41.5,42.5\n",
        "0,1,2,3,4,6\n40.5,41.5,42.5,43.5,41.5,42.5\n",
        "a,0,1,2,3,4,5\nb,40.5,41.5,42.5,43.5,41.5,42.5\n",
    ],
)
def test_points_that_are_not_a_header(tmp_path, text):
    found = _read(tmp_path, text)
    assert (len(found.rest), found.rest[0].tolist()) == (2, [0, 1, 2])


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ([f"{i},{row}" for i, row in enumerate(ROWS)], "the first of 7 columns counts the rows"),
        ([f"{row},{i}" for i, row in enumerate(ROWS, 1)], "the last of 7 columns counts the rows"),
        ([f"{i},{row},1" for i, row in enumerate(ROWS)], "line 1: expected numbers px"),
        ([row.rpartition(",")[0] for row in ROWS], "line 1: expected numbers px"),
        (["0,1,2,3,4,5", *ROWS], "can be a header that counts the columns, "),
        ([",0,1,2,3,4,5", *ROWS], "can be a header that counts the columns, "),
    ],
    ids=["index", "index last", "index and weight", "a column is missing", "pandas", "its index"],
)
def test_numbers_that_fit_no_layout_are_refused(tmp_path, rows, sentence):
    with pytest.raises(ValueError, match=rf"x\.csv`.*{sentence}.*; {ADVICE}$"):
        _read(tmp_path, "\n".join(rows))


def test_weights_and_whole_coordinates_are_read(tmp_path):
    rows = [f"{row},{weight}" for row, weight in zip(ROWS, (1, 1, 2))]
    assert _read(tmp_path, "\n".join(rows)).weights.tolist() == [1, 1, 2]
    found = _read(tmp_path, "7,0,1,9,0,1,0.5\n9,2,1,9,2,1,1.5\n")
    assert found.rest.tolist() == [[7, 0, 1], [9, 2, 1]]
    rows = [f"{i},{row}" for i, row in enumerate(ROWS)]
    _assert_pairs(_read(tmp_path, _table("index,px,py,pz,qx,qy,qz", rows)))


def test_labels_between_tabs_may_have_blanks(tmp_path):
    found = _read(tmp_path, "left eye\t1\t2\t3\t4\t5\t6\nnose\t1\t2\t3\t4\t5\t6\n", "x.txt")
    assert found.labels == ["left eye", "nose"]
