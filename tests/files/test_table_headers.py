"""What the first row of a table says: which columns are p and q, or that it is a point itself."""

import io as text_io
import itertools

import numpy as np
import pytest
from vtk_fixtures import update

from vtk_mls import io
from vtk_mls.files import control_point_files
from vtk_mls.filters import MLSControlPoints
from vtk_mls.vtk import arrays

REST = np.array([(40.5, 41.25, 42.5), (60.5, 40.5, 40.5), (40.5, 60.5, 40.25)])
DEFORMED = REST + [(3.5, 0, 0), (0, 1.25, 0), (0, 0, -2.5)]
ROWS = [",".join(map(repr, row)) for row in np.hstack([REST, DEFORMED]).tolist()]


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
        "x_moving,y_moving,z_moving,x_fixed,y_fixed,z_fixed",
        "moving_x,moving_y,moving_z,target_x,target_y,target_z",
        "MovingX,MovingY,MovingZ,FixedX,FixedY,FixedZ",
        "x (source),y (source),z (source),x (target),y (target),z (target)",
        "rest.x,rest.y,rest.z,deformed.x,deformed.y,deformed.z",
        "x_old,y_old,z_old,x_new,y_new,z_new",
        "x,y,z,new_x,new_y,new_z",
        "X,Y,Z,X1,Y1,Z1",
        "x,y,z,x.1,y.1,z.1",
        "x1,y1,z1,x2,y2,z2",
        "x (mm),y (mm),z (mm),x_moved (mm),y_moved (mm),z_moved (mm)",
        "xp,yp,zp,xq,yq,zq",
        '"px","py","pz","qx","qy","qz"',
        "\ufeffpx,py,pz,qx,qy,qz",
        "# px,py,pz,qx,qy,qz",
        "# made by hand\n# x,y,z,new_x,new_y,new_z",
        "# px,py,pz,qx,qy,qz\npx,py,pz,qx,qy,qz",
    ],
)
def test_names_of_both_positions(tmp_path, header):
    _assert_pairs(_read(tmp_path, _table(header)))


@pytest.mark.parametrize(
    "header",
    [
        "x_fixed,y_fixed,z_fixed,x_moving,y_moving,z_moving",
        "qx,qy,qz,px,py,pz",
        "x_after,y_after,z_after,x_before,y_before,z_before",
        "x2,y2,z2,x1,y1,z1",
    ],
)
def test_names_count_and_not_the_order(tmp_path, header):
    _assert_pairs(_read(tmp_path, _table(header)), DEFORMED, REST)


@pytest.mark.parametrize("header", ["x,y,z,dx,dy,dz", "# x y z dx dy dz", "px,py,pz,dx,dy,dz"])
def test_displacements_are_added(tmp_path, header):
    _assert_pairs(_read(tmp_path, _table(header)), REST, REST + DEFORMED)


@pytest.mark.parametrize(
    "header",
    [
        '"Label","Use","X","Y","Z","X1","Y1","Z1"',
        '"Label","Use","X","Y","Z,"X1","Y1","Z1"',  # as flybrains has it
        "name,active,x_moving,y_moving,z_moving,x_fixed,y_fixed,z_fixed",
        "name,active,x,y,z,u,v,w",
    ],
)
@pytest.mark.parametrize("words", [("true", "false"), ("True", "False"), ("1", "0")])
def test_landmarks_of_bigwarp_with_a_header(tmp_path, header, words):
    yes, no = words
    infinite = ",".join(3 * ['"Infinity"'])
    rows = [f'"Pt-{i}","{yes}",{row}' for i, row in enumerate(ROWS)]
    rows += [f'"Pt-8","{no}",1,2,3,4,5,6', f'"Pt-9","{no}",{infinite},4,5,6']
    found = _read(tmp_path, _table(header, rows))
    _assert_pairs(found)
    assert found.labels == ["Pt-0", "Pt-1", "Pt-2"]
    with pytest.raises(ValueError, match=r"not a finite number in line 2$"):
        _read(tmp_path, _table(header, [f"Pt-9,{yes},{infinite},4,5,6"]))
    with pytest.raises(ValueError, match=r"line 2: expected 8 cells in each line"):
        _read(tmp_path, _table(header, ["Pt-9,perhaps,1,2,3,4,5,6"]))


def test_positions_that_are_not_used_are_left_out(tmp_path):
    text = "use,x,y,z\ntrue,1,2,3\nfalse,4,5,6\n"
    assert _read(tmp_path, text).rest.tolist() == [[1, 2, 3]]
    points = control_point_files.read_landmarks(tmp_path / "x.csv")
    control_point_files.write_landmarks(tmp_path / "y.csv", points, tmp_path / "x.csv")
    assert (tmp_path / "y.csv").read_text() == "use,x,y,z\ntrue,1.0,2.0,3.0\nfalse,4,5,6\n"


@pytest.mark.parametrize(
    "names",
    ["u, v, w", "x_sym, y_sym, z_sym", "ux, uy, uz", "x_fixed, y_fixed, z_fixed", "nx, ny, nz"],
)
def test_columns_that_fit_no_rule_are_asked_about(tmp_path, names, caplog):
    sentence = rf"x\.csv`: it is not clear what the columns {names} are; call them qx,qy,qz if"
    for header in (f"x,y,z,{names.replace(' ', '')}", f"# x,y,z,{names.replace(' ', '')}"):
        with pytest.raises(ValueError, match=sentence):
            _read(tmp_path, _table(header))
        with pytest.raises(ValueError, match=sentence):
            io.read_control_points(tmp_path / "x.csv")
    assert not caplog.records
    # positions of something else, or of a second file, are those of x, y and z
    found = control_point_files.read_landmarks(tmp_path / "x.csv")
    np.testing.assert_array_equal(found.positions, REST)
    assert f"columns {names} are ignored" in caplog.text


@pytest.mark.parametrize(
    ("header", "names"),
    [
        ("x_a,y_a,z_a,x_b,y_b,z_b", "x_a, y_a, z_a; x_b, y_b, z_b"),
        ("axis-0,axis-1,axis-2,x_,b,c", "axis-0, axis-1, axis-2"),  # z, y, x of napari
        ("u,v,w,a,b,c", "u, v, w"),
        ("dx,dy,dz,a,b,c", "dx, dy, dz"),
    ],
)
def test_positions_of_which_nothing_is_known_are_asked_about(tmp_path, header, names):
    for is_alone in (True, False):
        (tmp_path / "x.csv").write_text(_table(header))
        with pytest.raises(ValueError, match=f"line 1: it is not clear which .* {names} are; call"):
            control_point_files.read_landmarks(tmp_path / "x.csv", is_alone=is_alone)


def test_a_position_of_any_name_is_taken_by_it(tmp_path):
    _read(tmp_path, "x,y,z\n1,2,3\n", "p.csv")
    for header in ("z_moving,y_moving,x_moving", "z_um,y_um,x_um", "qz,qy,qx"):
        (tmp_path / "q.csv").write_text(f"{header}\n6,5,4\n")
        found = control_point_files.read_pairs(tmp_path / "p.csv", tmp_path / "q.csv")
        assert found.deformed.tolist() == [[4, 5, 6]]


@pytest.mark.parametrize(
    ("header", "sentence"),
    [
        ("x,y,z,x,y,z", "several columns are x, y, z$"),
        ("px,py,pz,qx,qy,q", "expected columns qx, qy, qz, got"),
        ("x_moving,y_moving,z_moving,x_fixed,y_fixed,zz", "expected columns x_fixed, y_fixed, z_f"),
        ("x,y,z,Displacement:0,Displacement:1,c", "Displacement:0, Displacement:1, Displacement:2"),
        ("rest,rest,rest,deformed,deformed,deformed\nx,y,z,x,y,z", "line 2: expected numbers px"),
    ],
)
def test_names_that_are_missing_or_twice_there(tmp_path, header, sentence):
    with pytest.raises(ValueError, match=sentence):
        _read(tmp_path, _table(header))


def _frame(pandas, dtype=float):
    return pandas.DataFrame(np.hstack([REST, DEFORMED]).astype(dtype))


FORMS = [
    (sep, decimal)
    for sep, decimal in itertools.product([",", ";", "\t", " "], [".", ","])
    if (sep, decimal) not in [(",", ","), (" ", ",")]
]


@pytest.mark.parametrize(("sep", "decimal"), FORMS)
@pytest.mark.parametrize("index", [True, False], ids=["index", "no index"])
@pytest.mark.parametrize(
    "names", [range(6), list("abcdef"), ["px", "py", "pz", "qx", "qy", "qz"]], ids=repr
)
def test_tables_of_pandas(tmp_path, sep, decimal, index, names):
    pandas = pytest.importorskip("pandas")
    frame = _frame(pandas)
    frame.columns = names
    _assert_pairs(_read(tmp_path, frame.to_csv(sep=sep, decimal=decimal, index=index)))


@pytest.mark.parametrize(("sep", "decimal"), FORMS)
@pytest.mark.parametrize("index", [True, False], ids=["index", "no index"])
def test_two_tables_of_pandas(tmp_path, sep, decimal, index):
    pandas = pytest.importorskip("pandas")
    form = {"sep": sep, "decimal": decimal, "index": index}
    for name, positions in {"p.csv": REST, "q.csv": DEFORMED}.items():
        (tmp_path / name).write_text(pandas.DataFrame(positions).to_csv(**form))
    _assert_pairs(control_point_files.read_pairs(tmp_path / "p.csv", tmp_path / "q.csv"))


def test_an_index_of_labels_is_the_labels(tmp_path):
    pandas = pytest.importorskip("pandas")
    labels = ["nose", "ear", "eye"]
    frame = _frame(pandas).set_axis(labels)
    named = frame.set_axis(["px", "py", "pz", "qx", "qy", "qz"], axis=1)
    texts = [table.to_csv(sep=sep) for table in (frame, named) for sep in ",\t"]
    for text in (*texts, frame.reset_index().to_csv(index=False)):
        found = _read(tmp_path, text)
        _assert_pairs(found)
        assert found.labels == labels
    (tmp_path / "p.csv").write_text(frame[[0, 1, 2]].to_csv())
    (tmp_path / "q.csv").write_text(frame[[3, 4, 5]].iloc[::-1].set_axis(range(3), axis=1).to_csv())
    _assert_pairs(control_point_files.read_pairs(tmp_path / "p.csv", tmp_path / "q.csv"))


def test_a_part_of_a_frame_keeps_its_numbers(tmp_path):
    pandas = pytest.importorskip("pandas")
    wide = pandas.DataFrame(np.hstack([np.zeros((3, 2)), REST, DEFORMED]))
    _assert_pairs(_read(tmp_path, wide.iloc[:, 2:].to_csv()))


def test_columns_of_texts_tell_a_header(tmp_path):
    pandas = pytest.importorskip("pandas")
    frame = _frame(pandas, int).set_axis(range(1, 7), axis=1)
    frame.insert(0, 0, ["a", "b", "c"])
    for index in (True, False):
        found = _read(tmp_path, frame.to_csv(index=index))
        _assert_pairs(found, REST.astype(int), DEFORMED.astype(int))
        assert found.labels == ["a", "b", "c"]
    frame = _frame(pandas).set_axis(range(2, 8), axis=1)
    frame.insert(0, 1, [True, False, True])
    frame.insert(0, 0, ["a", "b", "c"])
    for index in (True, False):
        found = _read(tmp_path, frame.to_csv(index=index))
        _assert_pairs(found, REST[::2], DEFORMED[::2])


@pytest.mark.parametrize(
    "text",
    [
        "0,1,2,3,4,5\n40,41,42,43,41,42\n",
        "0,1,2,3,4,5\n40.5,41,42,43,41,42\n",
        "0,1,2,3,4,5\n",
        ",0,1,2,3,4,5\n,40,41,42,43,41,42\n",
        "0 1 2\n6 7 8\n",
        "0,1,2,3,4,5,6\n40,41,42,43,41,42,1\n",
    ],
)
def test_a_row_that_can_be_a_header_or_a_point_is_asked_about(tmp_path, text):
    first = text.partition("\n")[0].replace(" ", ",")
    sentence = (
        rf"x\.csv`, line 1: `{first}` can be a header that counts .*, or the first point; put"
    )
    with pytest.raises(ValueError, match=sentence):
        _read(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("px,py,pz,qx,qy,qz\n0,1,2,3,4,5\n40,41,42,43,41,42\n", [0, 1, 2]),
        ("# px py pz qx qy qz\n0,1,2,3,4,5\n40,41,42,43,41,42\n", [0, 1, 2]),
        ("0.0,1.0,2.0,3.0,4.0,5.0\n40.5,41.5,42.5,43.5,41.5,42.5\n", [0, 1, 2]),
        ("1,2,3,4,5,6\n40.5,41.5,42.5,43.5,41.5,42.5\n", [1, 2, 3]),
        ("0,1,2,3,4,6\n40.5,41.5,42.5,43.5,41.5,42.5\n", [0, 1, 2]),
        ("a,0,1,2,3,4,5\nb,40.5,41.5,42.5,43.5,41.5,42.5\n", [0, 1, 2]),
    ],
)
def test_points_that_are_no_header(tmp_path, text, first):
    found = _read(tmp_path, text)
    assert (len(found.rest), found.rest[0].tolist()) == (2, first)


def test_tables_of_r(tmp_path):
    rows = [f'"{i}",{row}' for i, row in enumerate(ROWS, 1)]
    _assert_pairs(_read(tmp_path, _table('"","V1","V2","V3","V4","V5","V6"', rows)))  # write.csv
    rows = [row.replace(",", " ") for row in rows]  # write.table
    for header in ('"V1" "V2" "V3" "V4" "V5" "V6"', '"px" "py" "pz" "qx" "qy" "qz"'):
        _assert_pairs(_read(tmp_path, _table(header, rows), "x.txt"))


@pytest.mark.parametrize("header", ["", "id,a,b,c,d,e,f\n"])
@pytest.mark.parametrize("start", [0, 1])
def test_an_index_without_a_name_is_asked_about(tmp_path, header, start):
    rows = "".join(f"{i},{row}\n" for i, row in enumerate(ROWS, start))
    with pytest.raises(
        ValueError, match=r"x\.csv`: the first of 7 columns has whole numbers, and can"
    ):
        _read(tmp_path, header + rows)
    _assert_pairs(_read(tmp_path, "index,px,py,pz,qx,qy,qz\n" + rows))
    found = _read(tmp_path, "px,py,pz,qx,qy,qz,weight\n" + rows)
    assert found.rest[:, 0].tolist() == [start, start + 1, start + 2]


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        (
            [f"{i},{row}" for i, row in zip((7, 19, 4), ROWS)],
            "the first of 7 columns .* index or x",
        ),
        ([f"{row},{i}" for i, row in enumerate(ROWS, 1)], "the last of 7 columns .* or a weight"),
        ([f"{i},{row},1" for i, row in enumerate(ROWS)], "line 1: .*`: which column is what"),
        ([row.rpartition(",")[0] for row in ROWS], "line 1: .*`: which column is what"),
    ],
    ids=["identifiers", "index last", "index and weight", "a column is missing"],
)
def test_numbers_that_fit_no_rule_are_asked_about(tmp_path, rows, sentence):
    with pytest.raises(ValueError, match=rf"x\.csv`.*{sentence}"):
        _read(tmp_path, "\n".join(rows))


def test_weights_and_whole_coordinates_are_not_asked_about(tmp_path):
    rows = [f"{row},{weight}" for row, weight in zip(ROWS, (1, 1, 2))]
    assert _read(tmp_path, "\n".join(rows)).weights.tolist() == [1, 1, 2]
    found = _read(tmp_path, "7,0,1,9,0,1,0.5\n9,2,1,9,2,1,1.5\n")
    assert found.rest.tolist() == [[7, 0, 1], [9, 2, 1]]


def test_a_missing_partner_is_an_error(tmp_path):
    pandas = pytest.importorskip("pandas")
    frame = _frame(pandas)
    frame.iloc[1, 4] = np.nan
    for options in ({}, {"index": False}, {"na_rep": "nan"}):
        with pytest.raises(ValueError, match=r"line 3: expected numbers|finite number in line 3$"):
            _read(tmp_path, frame.to_csv(**options))


@pytest.mark.parametrize("sep", [",", "\t"])
def test_what_is_written_again_keeps_header_and_index(tmp_path, sep):
    pandas = pytest.importorskip("pandas")
    (tmp_path / "x.csv").write_text(pandas.DataFrame(REST).to_csv(sep=sep))
    points = control_point_files.read_landmarks(tmp_path / "x.csv")
    np.testing.assert_array_equal(points.positions, REST)
    control_point_files.write_landmarks(tmp_path / "y.csv", points, tmp_path / "x.csv")
    frame = pandas.read_csv(
        text_io.StringIO((tmp_path / "y.csv").read_text()), sep=sep, index_col=0
    )
    np.testing.assert_array_equal(frame.to_numpy(), REST)
    assert [*frame.columns] == ["0", "1", "2"]


def test_labels_between_tabs_may_have_blanks(tmp_path):
    found = _read(tmp_path, "left eye\t1\t2\t3\t4\t5\t6\nnose\t1\t2\t3\t4\t5\t6\n", "x.txt")
    assert found.labels == ["left eye", "nose"]


def test_a_source_reads_and_asks_as_the_functions_do(tmp_path, messages):
    source = MLSControlPoints()
    source.SetMode("file")
    source.SetFileName(str(tmp_path / "x.csv"))
    (tmp_path / "x.csv").write_text(_table("0,1,2,3,4,5"))
    p, q, _ = arrays.control_points(update(source), "Displacement")
    np.testing.assert_array_equal(p, REST)
    np.testing.assert_allclose(q, DEFORMED, rtol=1e-15)
    for header, sentence in {
        "x,y,z,u,v,w": r"it is not clear what the columns u, v, w are",
        "0,1,2,3,4,5\n1,2,3,4,5,6": r"can be a header that counts the columns",
    }.items():
        (tmp_path / "x.csv").write_text(_table(header))
        source.Modified()
        assert not source.GetExecutive().Update()
        messages.assert_one(sentence)
    for name, sentence in {"": "choose one", str(tmp_path): "is a folder; expected"}.items():
        source.SetFileName(name)
        assert not source.GetExecutive().Update()
        messages.assert_one(f"`FileName`.*{sentence}")
