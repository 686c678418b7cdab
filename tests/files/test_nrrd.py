"""NRRD files: spellings, spaces, vectors, components, and files that are refused."""

import bz2
import gzip
import itertools
import struct
import tracemalloc

import nrrd
import numpy as np
import pytest
import SimpleITK
from file_fixtures import (
    COLORS,
    NRRD,
    NRRD_DATA,
    ORIGIN,
    RIGHT,
    SMALL,
    SPACING,
    VALUES,
    VECTORS,
    assert_refused,
    field_on,
    itk_matrix,
    matrix,
    nrrd_bytes,
    scalars,
    write_by_itk,
)
from vtk_fixtures import make_image

from vtk_mls import io
from vtk_mls.files import metadata
from vtk_mls.vtk.arrays import ImageGeometry

WORDS = [("right", "left"), ("anterior", "posterior"), ("superior", "inferior")]
SPATIAL = (
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 6 7\n"
    "space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
    "space origin: (7,8,9)\nendian: little\nencoding: raw\n"
)
PLAIN = (
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 6 7\nspacings: 2 3 4\naxis mins: 10 20 30\n"
    "centers: cell node cell\nendian: little\nencoding: raw\n"
)
SPELLINGS = [
    (SPATIAL, {"space directions": "spacedirections", "space origin": "spaceorigin"}),
    (SPATIAL, {"endian: little": "endian: Little"}),
    (SPATIAL, {"type: short": "type: signed short int"}),
    (SPATIAL, {"type: short": "Type: INT16_t"}),
    (SPATIAL, {"encoding: raw": "encoding: hex"}),
    (SPATIAL, {"encoding: raw": "encoding: RAW"}),
    (SPATIAL, {"encoding: raw": "encoding: txt"}),
    (SPATIAL, {"\n": "\r\n"}),
    (SPATIAL, {"encoding": '# a comment: of ours\nlabels: "x" "y: z" ""\nkey:=a\\nb\nencoding'}),
    (SPATIAL, {"encoding": "oldmin: 0\noldmax: 3\nsampleunits: m\nencoding"}),
    (SPATIAL, {"encoding": "kinds: Domain Space domain\nencoding"}),
    (PLAIN, {}),
    (PLAIN, {"axis mins": "axismins", "centers": "centerings"}),
    (PLAIN, {"centers: cell node cell\n": ""}),
    (PLAIN, {"encoding": "kinds: ??? ??? ???\nencoding"}),
]


@pytest.mark.parametrize(
    ("changes", "data"),
    [
        ({}, NRRD_DATA),
        ({"encoding: raw": "encoding: gzip"}, gzip.compress(NRRD_DATA)),
        ({"encoding: raw": "encoding: bz2"}, bz2.compress(NRRD_DATA)),
        ({"encoding: raw": "encoding: ascii"}, b"1 2\n3 400\n"),
        ({"endian: little": "endian: big"}, struct.pack(">4h", 1, 2, 3, 400)),
        ({"endian: little": "endian: little\nbyte skip: -1"}, b"rubbish" + NRRD_DATA),
    ],
    ids=["raw", "gzip", "bzip2", "text", "big-endian", "at the end"],
)
def test_nrrd(tmp_path, changes, data):
    header = NRRD
    for old, new in changes.items():
        header = header.replace(old, new)
    (tmp_path / "x.nrrd").write_bytes(header.encode() + b"\n" + data)
    (tmp_path / "y.nhdr").write_text(header + "data file: y.raw\n")
    (tmp_path / "y.raw").write_bytes(data)
    for path in (tmp_path / "x.nrrd", tmp_path / "y.nhdr"):
        image = io.read_dataset(path)
        assert scalars(image).tolist() == [1, 2, 3, 400]
        assert scalars(image).dtype == np.int16
        points = ImageGeometry.of_image(image).grid.points()
        # y of the file points to the front, ours to the back
        np.testing.assert_allclose(points, [(5, -6, 7), (5, -8, 7), (2, -6, 7), (2, -8, 7)])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("sizes: 2 2 1\n", ""), "it has no field 'sizes'"),
        (("type: short", "type: block"), "values of type `block` are not supported"),
        (("encoding: raw", "encoding: zrl"), "the encoding `zrl` is not supported"),
        (("endian: little\n", ""), "its values of type `short` need a field `endian`"),
        (("sizes: 2 2 1", "sizes: 2 2 2"), "expected 8 values, got 4"),
        (("encoding: raw", "encoding: gzip"), "incorrect header check"),
        (("(0,0,4)", "none"), "three axes in space"),
        (("(0,0,4)", "(0,4)"), "three axes in space"),
        (("(0,0,4)", ""), "three axes in space"),
        (("(0,0,4)", "(0,0,4) none"), "three axes in space"),
        (("(5,6,7)", "(5,6)"), "three axes in space"),
        (("sizes: 2 2 1", "sizes: 2 -2 1"), "its sizes must be positive, got `2 -2 1`"),
        (("endian: little", "endian: middle"), "`endian` must be little or big, got `middle`"),
        (("space:", "line skip: 99999999999\nspace:"), "expected 4 values, got 0"),
        (("encoding: raw", "encoding: bz2"), "Invalid data stream"),
        (("encoding: raw", "encoding: ascii"), "invalid literal"),
        (("encoding: raw", "data file: y.raw\nencoding: raw"), "there is no data file `.*y.raw`"),
        (("NRRD", "nrrd"), "does not begin with NRRD"),
        (("dimension: 3", "dimension: 4"), "as many sizes as dimensions, 4, got 3"),
        (("type: short", "type: char"), "`char` are not supported"),
        (("encoding: raw", "encoding: hex"), "non-hexadecimal|'ascii' codec"),
    ],
)
def test_bad_nrrd(tmp_path, change, sentence):
    content = NRRD.replace(*change).encode() + b"\n" + NRRD_DATA
    sentence = rf"x\.nrrd` is not a (readable )?NRRD volume.*: .*({sentence})"
    assert_refused(tmp_path / "x.nrrd", content, sentence)


def test_bad_text_in_nrrd(tmp_path):
    header = NRRD.replace("encoding: raw", "encoding: ascii")
    for text, sentence in (
        ("1 2\n3 400000", "values must be from -32768 to 32767, got 400000"),
        ("1 2\n3 " + 30 * "9", "too large"),
        ("1 2\n3 4.5", "invalid literal"),
        ("1 2\n3", "expected 4 values, got 3"),
        ("1 2\n3 " + 9999 * "x", "invalid literal"),
    ):
        sentence = rf"x\.nrrd` is not a (readable )?NRRD volume.*{sentence}"
        assert_refused(tmp_path / "x.nrrd", f"{header}\n{text}\n", sentence)


@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress])
def test_no_more_is_unpacked_than_the_volume_needs(tmp_path, pack):
    name = "gzip" if pack is gzip.compress else "bz2"
    header = NRRD.replace("encoding: raw", f"encoding: {name}").replace("type: short", "type: int8")
    (tmp_path / "x.nrrd").write_bytes(header.encode() + b"\n" + pack(bytes(200_000_000)))
    tracemalloc.start()
    assert scalars(io.read_dataset(tmp_path / "x.nrrd")).tolist() == [0, 0, 0, 0]
    assert tracemalloc.get_traced_memory()[1] < 20_000_000
    tracemalloc.stop()


def test_directions_that_are_none(tmp_path):
    for place in ("(0,nan,0)", "(0,0,0)", "(0,1e400,0)"):
        (tmp_path / "x.nrrd").write_bytes(
            NRRD.replace("(0,2,0)", place).encode() + b"\n" + NRRD_DATA
        )
        with pytest.raises(ValueError, match=r"x\.nrrd` cannot be used: its steps between voxels"):
            io.read_dataset(tmp_path / "x.nrrd")


def test_colors_of_nrrd_are_colors_for_itk(tmp_path):
    for components in (3, 4):
        image = io.read_dataset(write_by_itk(tmp_path / "x.mha", COLORS[..., :components].copy()))
        io.write_dataset(image, tmp_path / "x.nrrd")
        kind = "RGB-color" if components == 3 else "RGBA-color"
        assert f"\nkinds: {kind} domain".encode() in (tmp_path / "x.nrrd").read_bytes()
        back = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(tmp_path / "x.nrrd")))
        np.testing.assert_array_equal(back, COLORS[..., :components])


@pytest.mark.parametrize("kind", ["vector", "covariant-vector", "3-color", "list"])
def test_vectors_of_nrrd_turn_if_their_frame_is_known(tmp_path, kind):
    frame = "measurement frame: (0,1,0) (-1,0,0) (0,0,1)\n"
    to_space = np.array([(0, 1, 0), (-1, 0, 0), (0, 0, 1)]).T  # columns are the three vectors
    (tmp_path / "x.nrrd").write_bytes(nrrd_bytes("RAS", RIGHT, VECTORS, frame, kind))
    image = io.read_dataset(tmp_path / "x.nrrd")
    turns = "vector" in kind
    expected = VECTORS.reshape(504, 3) @ (np.diag([-1, -1, 1]) @ to_space).T if turns else VECTORS
    np.testing.assert_array_equal(scalars(image), np.reshape(expected, (504, 3)))
    assert (image.GetPointData().GetVectors() is not None) == turns
    io.write_dataset(image, tmp_path / "y.nrrd")
    content = (tmp_path / "y.nrrd").read_bytes()
    assert f"\nkinds: {kind} domain domain domain\n".encode() in content
    assert (b"\nspace: left-posterior-superior\n" if turns else b"\nspace: RAS\n") in content
    itk = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(tmp_path / "y.nrrd")))
    np.testing.assert_array_equal(itk.reshape(504, 3), scalars(image))
    assert (b"(1,0,0) (0,1,0) (0,0,1)" if turns else frame.encode()) in content
    np.testing.assert_array_equal(scalars(io.read_dataset(tmp_path / "y.nrrd")), scalars(image))
    # without a frame nothing turns
    (tmp_path / "x.nrrd").write_bytes(nrrd_bytes("RAS", RIGHT, VECTORS, "", kind))
    values = scalars(io.read_dataset(tmp_path / "x.nrrd"))
    np.testing.assert_array_equal(values, VECTORS.reshape(504, 3))


@pytest.mark.parametrize("words", list(itertools.product(*WORDS)), ids="-".join)
def test_every_space_of_nrrd(tmp_path, words):
    letters = "".join(word[0] for word in words)
    for space in ("-".join(words), letters.upper(), letters, "-".join(words).title()):
        (tmp_path / "x.nrrd").write_bytes(nrrd_bytes(space, RIGHT))
        image = io.read_dataset(tmp_path / "x.nrrd")
        np.testing.assert_allclose(matrix(image), np.column_stack([RIGHT * SPACING, ORIGIN]))
        io.write_dataset(image, tmp_path / "y.nrrd")
        assert f"\nspace: {space}\n".encode() in (tmp_path / "y.nrrd").read_bytes()
        back = matrix(io.read_dataset(tmp_path / "y.nrrd"))
        np.testing.assert_allclose(back, matrix(image), atol=1e-12)


@pytest.mark.parametrize("space", ["scanner-xyz", "3D-right-handed", "3d-left-handed", ""])
def test_spaces_of_no_patient_are_taken_as_they_are(tmp_path, space):
    content = nrrd_bytes("LPS", RIGHT)
    line = f"space: {space}" if space else "space dimension: 3"
    (tmp_path / "x.nrrd").write_bytes(content.replace(b"space: LPS", line.encode()))
    image = io.read_dataset(tmp_path / "x.nrrd")
    np.testing.assert_allclose(matrix(image), np.column_stack([RIGHT * SPACING, ORIGIN]))
    io.write_dataset(image, tmp_path / "y.nrrd")
    space_line = f"\nspace: {space or 'left-posterior-superior'}\n"
    assert space_line.encode() in (tmp_path / "y.nrrd").read_bytes()


@pytest.mark.parametrize(
    "space", ["right-anterior-superior-time", "RAST", "scanner-xyz-time", "up"]
)
def test_other_spaces_are_refused(tmp_path, space):
    content = nrrd_bytes("RAS", RIGHT).replace(b"space: RAS", f"space: {space}".encode())
    sentence = rf"x\.nrrd` .* its space `{space}` is not one of three"
    assert_refused(tmp_path / "x.nrrd", content, sentence)


def test_key_value_pairs_and_fields_stay(tmp_path):
    more = 'content: a: b\nspace units: "mm" "mm" "mm"\nkey:=value: and := more\nName:=\u00e4\\n\n'
    (tmp_path / "x.nrrd").write_bytes(nrrd_bytes("RAS", RIGHT, more=more))
    image = io.read_dataset(tmp_path / "x.nrrd")
    assert metadata.load(image, metadata.NRRD_HEADER) == tuple(more.splitlines())
    for step in (1, 2):
        io.write_dataset(image, tmp_path / f"y{step}.nrrd")
        header = (tmp_path / f"y{step}.nrrd").read_bytes().partition(b"\n\n")[0].decode()
        assert set(more.splitlines()) <= set(header.splitlines())
        image = io.read_dataset(tmp_path / f"y{step}.nrrd")
    io.write_dataset(image, tmp_path / "x.vti")  # on the way through VTK's own format, too
    io.write_dataset(io.read_dataset(tmp_path / "x.vti"), tmp_path / "z.nrrd")
    assert (tmp_path / "z.nrrd").read_bytes() == (tmp_path / "y2.nrrd").read_bytes()


def test_field_data_cannot_change_a_nrrd_header(tmp_path):
    image = io.read_dataset(write_by_itk(tmp_path / "x.mha", VALUES))
    lines = ["data file: /etc/passwd", "encoding: raw", "a:=b\n\nc", "content: d\nsizes: 1 1 1"]
    metadata.store(image, metadata.NRRD_HEADER, lines)
    io.write_dataset(image, tmp_path / "x.nrrd")
    back = io.read_dataset(tmp_path / "x.nrrd")
    np.testing.assert_array_equal(scalars(back), VALUES.ravel())
    header_lines = metadata.load(back, metadata.NRRD_HEADER)
    assert header_lines == ("content: d\\nsizes: 1 1 1", "a:=b\\n\\nc")


def test_active_vectors_are_vectors_in_nrrd(tmp_path):
    image = io.read_dataset(write_by_itk(tmp_path / "x.mha", VECTORS))
    image.GetPointData().SetActiveVectors("MetaImage")
    io.write_dataset(image, tmp_path / "x.nrrd")
    assert b"\nkinds: vector domain" in (tmp_path / "x.nrrd").read_bytes()
    back = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(tmp_path / "x.nrrd")))
    np.testing.assert_array_equal(back, VECTORS)
    assert io.read_dataset(tmp_path / "x.nrrd").GetPointData().GetVectors() is not None


@pytest.mark.parametrize(("header", "changes"), SPELLINGS)
def test_other_spellings_of_nrrd_are_read_as_by_itk(tmp_path, header, changes):
    for old, new in changes.items():
        header = header.replace(old, new)
    data = SMALL.tobytes()
    if "hex" in header:
        data = data.hex().encode()
    if "txt" in header:
        data = " ".join(map(str, SMALL.ravel())).encode()
    end = "\r\n" if "\r\n" in header else "\n"
    (tmp_path / "x.nrrd").write_bytes((header + end).encode() + data)
    image = io.read_dataset(tmp_path / "x.nrrd")
    itk = SimpleITK.ReadImage(str(tmp_path / "x.nrrd"))
    np.testing.assert_array_equal(scalars(image), SMALL.ravel())
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(itk), SMALL)
    np.testing.assert_allclose(matrix(image), itk_matrix(tmp_path / "x.nrrd"))


@pytest.mark.parametrize("field", ["data file", "DATAFILE"])
@pytest.mark.parametrize(
    ("skip", "before", "after"),
    [
        *((f"{name}: 3", b"abc", b"x") for name in ("byte skip", "ByteSkip")),
        ("byteskip: -1", b"abc", b""),
        ("lineskip: 2", b"abc\n\n", b"x"),
    ],
)
def test_skips_of_detached_nrrd(tmp_path, field, skip, before, after):
    (tmp_path / "v.raw").write_bytes(before + SMALL.tobytes() + after)
    (tmp_path / "x.nhdr").write_text(f"{SPATIAL}{skip}\n{field}: v.raw\n")
    np.testing.assert_array_equal(scalars(io.read_dataset(tmp_path / "x.nhdr")), SMALL.ravel())
    itk = SimpleITK.ReadImage(str(tmp_path / "x.nhdr"))
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(itk), SMALL)


@pytest.mark.parametrize(
    ("lines", "axis"),
    [
        ("sizes: 5 6 7 3\n", 3),
        ("sizes: 5 6 7 3\nspacings: 2 3 4 nan\n", 3),
        ("sizes: 3 5 6 7\nspacings: nan 2 3 4\n", 0),
        ("sizes: 5 6 7 3\nkinds: ??? ??? ??? ???\n", 3),
        ("sizes: 3 5 6 7\nkinds: ??? domain domain domain\n", 0),
        ("sizes: 5 6 7 3\nkinds: domain domain domain none\n", 3),
        ("sizes: 3 5 6 7\nkinds: VECTOR Domain domain space\n", 0),
        (
            "sizes: 3 5 6 7\nspace dimension: 3\n"
            "space directions: (nan,nan,nan) (2,0,0) (0,3,0) (0,0,4)\n",
            0,
        ),
        (
            "sizes: 5 6 7 3\nspace dimension: 3\n"
            "space directions: (2,0,0) (0,3,0) (0,0,4) none\nspace origin: (nan,nan,nan)\n",
            3,
        ),
    ],
)
def test_which_axis_of_nrrd_is_of_components(tmp_path, lines, axis, rng):
    shape = (5, 6, 7, 3) if axis == 3 else (3, 5, 6, 7)
    values = rng.normal(size=shape).astype("<f4")  # as pynrrd has it
    header = f"NRRD0004\ntype: float\ndimension: 4\n{lines}endian: little\nencoding: raw\n\n"
    (tmp_path / "x.nrrd").write_bytes(header.encode() + values.T.tobytes())
    np.testing.assert_array_equal(nrrd.read(str(tmp_path / "x.nrrd"))[0], values)
    image = io.read_dataset(tmp_path / "x.nrrd")
    assert image.GetDimensions() == (5, 6, 7)
    expected = np.moveaxis(values, axis, -1).transpose(2, 1, 0, 3).reshape(-1, 3)
    np.testing.assert_array_equal(scalars(image), expected)
    has_spacing = any(digit in lines for digit in ("2 3 4", "(2,0,0)"))
    assert image.GetSpacing() == ((2, 3, 4) if has_spacing else (1, 1, 1))
    io.write_dataset(image, tmp_path / "y.nrrd")
    itk = SimpleITK.ReadImage(str(tmp_path / "y.nrrd"))
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(itk).reshape(-1, 3), expected)


@pytest.mark.parametrize(("inverse", "kind"), [(False, "resampling"), (True, "modeling")])
def test_forward_fields_are_for_modeling(tmp_path, inverse, kind):
    io.write_field(field_on(make_image((4, 4, 4)), inverse), tmp_path / "x.nrrd")
    assert nrrd.read_header(str(tmp_path / "x.nrrd"))["displacement field type"] == kind
