"""What image files can say: types, components, scalings, spaces; and what they must not."""

import gzip
import itertools
import re
import struct
import subprocess
import sys

import nibabel
import numpy as np
import pytest
import SimpleITK
from test_frames import LEFT, ORIGIN, RIGHT, SPACING, VALUES, as_itk, as_nifti, nrrd_bytes
from test_io import scalars
from vtk_fixtures import messages  # noqa: F401

from vtk_mls import io
from vtk_mls.cli import main
from vtk_mls.files import provenance
from vtk_mls.vtk.arrays import ImageGeometry

TYPES = [f"{kind}{size}" for size in (8, 16, 32, 64) for kind in ("int", "uint")]
TYPES += ["float32", "float64"]
VECTORS = np.stack([VALUES, -VALUES, VALUES + 7.5], axis=-1).astype(np.float32)
COLOURS = (np.arange(7 * 8 * 9 * 4) % 251).astype(np.uint8).reshape(7, 8, 9, 4)


def matrix(image):
    """(3, 4) matrix from indices to the world of an image of ours."""
    grid = ImageGeometry.of_image(image).grid
    return np.column_stack([grid.index_to_world, grid.origin])


def in_lps(affine):
    return np.diag([-1, -1, 1]) @ affine[:3]


def limits(name):
    """A volume with the least and the greatest value of a type."""
    dtype = np.dtype(name)
    info = np.finfo(dtype) if dtype.kind == "f" else np.iinfo(dtype)
    values = VALUES.astype(dtype)
    values.flat[:2] = info.min, info.max
    return values


@pytest.mark.parametrize("name", TYPES)
@pytest.mark.parametrize("suffix", [".mha", ".nrrd", ".nii", ".nii.gz"])
def test_every_type(tmp_path, name, suffix):
    values = limits(name)
    SimpleITK.WriteImage(as_itk(RIGHT, values), str(tmp_path / f"x{suffix}"))
    image = io.read_dataset(tmp_path / f"x{suffix}")
    assert scalars(image).dtype == values.dtype
    np.testing.assert_array_equal(scalars(image), values.ravel())
    io.write_dataset(image, tmp_path / f"y{suffix}")
    back = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(tmp_path / f"y{suffix}")))
    assert back.dtype == values.dtype
    np.testing.assert_array_equal(back, values)


@pytest.mark.parametrize("kind", [nibabel.Nifti1Image, nibabel.Nifti2Image])
@pytest.mark.parametrize("order", "<>")
def test_nifti_of_both_versions_and_byte_orders(tmp_path, kind, order):
    source = as_nifti(LEFT, VALUES, kind)
    header = source.header.as_byteswapped(order)
    kind(source.dataobj, source.affine, header).to_filename(tmp_path / "x.nii")
    assert (tmp_path / "x.nii").read_bytes()[0 if order == "<" else 3] in (348 % 256, 540 % 256)
    image = io.read_dataset(tmp_path / "x.nii")
    np.testing.assert_array_equal(scalars(image), VALUES.ravel())
    np.testing.assert_allclose(matrix(image), in_lps(source.affine), atol=1e-5)


@pytest.mark.parametrize(
    ("slope", "intercept"), [(0.25, -3.5), (-2, 0), (1, 10), (0, 5), (np.nan, 7), (1, 0)]
)
@pytest.mark.parametrize("name", ["uint8", "int16", "float64"])
def test_nifti_scaling_is_nibabels(tmp_path, slope, intercept, name):
    source = as_nifti(RIGHT, limits(name) if name != "float64" else VALUES / 3)
    nibabel.save(source, tmp_path / "x.nii")
    content = bytearray((tmp_path / "x.nii").read_bytes())
    struct.pack_into("<2f", content, 112, slope, intercept)
    (tmp_path / "x.nii").write_bytes(content)
    expected = nibabel.load(tmp_path / "x.nii").get_fdata().T.ravel()
    np.testing.assert_allclose(scalars(io.read_dataset(tmp_path / "x.nii")), expected, rtol=1e-6)


@pytest.mark.parametrize("sform_code", [0, 1, 4])
@pytest.mark.parametrize("qform_code", [0, 1])
@pytest.mark.parametrize("direction", [RIGHT, LEFT], ids=["right", "left"])
def test_nifti_lies_where_nibabel_sees_it(tmp_path, sform_code, qform_code, direction):
    """Also if the two disagree, or neither counts."""
    source = as_nifti(direction)
    other = np.diag([2.0, 3, 4, 1])
    other[:3, 3] = 7, 8, 9
    source.set_sform(source.affine, sform_code)
    source.set_qform(other @ source.affine / 2 if sform_code else source.affine, qform_code)
    nibabel.save(source, tmp_path / "x.nii")
    expected = nibabel.load(tmp_path / "x.nii")
    assert expected.header["sform_code"] == sform_code
    image = io.read_dataset(tmp_path / "x.nii")
    np.testing.assert_allclose(matrix(image), in_lps(expected.affine), atol=1e-4)
    io.write_dataset(image, tmp_path / "y.nii")
    back = nibabel.load(tmp_path / "y.nii")
    np.testing.assert_allclose(back.affine, expected.affine, atol=1e-4)
    assert back.header["sform_code"] == sform_code
    assert back.header["qform_code"] == qform_code


def test_a_sheared_nifti_has_no_qform(tmp_path):
    affine = np.array([[2, 0.5, 0, 3], [0, 2, 0, 4], [0, 0.25, 3, 5], [0, 0, 0, 1.0]])
    nibabel.save(nibabel.Nifti1Image(VALUES.T, affine), tmp_path / "x.nii")
    io.write_dataset(io.read_dataset(tmp_path / "x.nii"), tmp_path / "y.nii")
    back = nibabel.load(tmp_path / "y.nii")
    np.testing.assert_allclose(back.affine, affine, atol=1e-5)
    assert back.header["qform_code"] == 0


def test_a_long_nifti_is_of_version_2(tmp_path):
    values = np.arange(40_000, dtype=np.int32).reshape(1, 2, 20_000).repeat(2, axis=2)
    SimpleITK.WriteImage(SimpleITK.GetImageFromArray(values), str(tmp_path / "x.mha"))
    io.write_dataset(io.read_dataset(tmp_path / "x.mha"), tmp_path / "x.nii")
    back = nibabel.load(tmp_path / "x.nii")
    assert isinstance(back, nibabel.Nifti2Image)
    np.testing.assert_array_equal(np.asarray(back.dataobj).T, values)
    np.testing.assert_array_equal(scalars(io.read_dataset(tmp_path / "x.nii")), values.ravel())


@pytest.mark.parametrize("order", "<>")
def test_nifti_in_two_files(tmp_path, order):
    source = as_nifti(LEFT)
    pair = nibabel.Nifti1Pair(source.dataobj, source.affine, source.header.as_byteswapped(order))
    nibabel.save(pair, tmp_path / "x.hdr")
    image = io.read_dataset(tmp_path / "x.hdr")
    np.testing.assert_array_equal(scalars(image), VALUES.ravel())
    np.testing.assert_allclose(matrix(image), in_lps(source.affine), atol=1e-5)
    (tmp_path / "x.img").unlink()
    with pytest.raises(ValueError, match=r"x\.hdr` .*there is no data file `.*x\.img`"):
        io.read_dataset(tmp_path / "x.hdr")
    nibabel.AnalyzeImage(VALUES.T, None).to_filename(tmp_path / "y.hdr")
    with pytest.raises(ValueError, match=r"y\.hdr` .*Analyze 7\.5 does not say"):
        io.read_dataset(tmp_path / "y.hdr")


@pytest.mark.parametrize("suffix", [".nii.gz", ".nrrd", ".mha"])
def test_a_wrong_checksum_is_noticed(tmp_path, suffix):
    SimpleITK.WriteImage(as_itk(RIGHT), str(tmp_path / f"x{suffix}"), useCompression=True)
    content = bytearray((tmp_path / f"x{suffix}").read_bytes())
    content[-1 if suffix == ".mha" else -8] ^= 1
    (tmp_path / f"x{suffix}").write_bytes(content)
    with pytest.raises(ValueError, match=rf"x\{suffix}` .*incorrect data check"):
        io.read_dataset(tmp_path / f"x{suffix}")


def test_nifti_colours(tmp_path):
    for components, names in ((3, "RGB"), (4, "RGBA")):
        dtype = np.dtype([(name, "u1") for name in names])
        values = np.ascontiguousarray(COLOURS[..., :components]).view(dtype)[..., 0]
        nibabel.save(as_nifti(RIGHT, values), tmp_path / "x.nii")
        image = io.read_dataset(tmp_path / "x.nii")
        np.testing.assert_array_equal(scalars(image), COLOURS[..., :components].reshape(504, -1))
        io.write_dataset(image, tmp_path / "y.nii")
        back = nibabel.load(tmp_path / "y.nii")
        np.testing.assert_array_equal(np.asarray(back.dataobj).T, values)


@pytest.mark.parametrize("suffix", [".nii", ".nii.gz", ".nrrd", ".mha"])
def test_components_go_to_itk_and_come_back(tmp_path, suffix):
    source = SimpleITK.GetImageFromArray(VECTORS, isVector=True)
    source.CopyInformation(as_itk(LEFT))
    SimpleITK.WriteImage(source, str(tmp_path / f"x{suffix}"))
    image = io.read_dataset(tmp_path / f"x{suffix}")
    np.testing.assert_array_equal(scalars(image), VECTORS.reshape(504, 3))
    io.write_dataset(image, tmp_path / f"y{suffix}")
    back = SimpleITK.ReadImage(str(tmp_path / f"y{suffix}"))
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(back), VECTORS)
    np.testing.assert_allclose(back.GetDirection(), LEFT.ravel(), atol=1e-6)


def test_colours_of_nrrd_are_colours_for_itk(tmp_path):
    for components in (3, 4):
        source = SimpleITK.GetImageFromArray(COLOURS[..., :components].copy(), isVector=True)
        SimpleITK.WriteImage(source, str(tmp_path / "x.mha"))
        io.write_dataset(io.read_dataset(tmp_path / "x.mha"), tmp_path / "x.nrrd")
        kind = "RGB-color" if components == 3 else "RGBA-color"
        assert f"\nkinds: {kind} domain".encode() in (tmp_path / "x.nrrd").read_bytes()
        back = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(tmp_path / "x.nrrd")))
        np.testing.assert_array_equal(back, COLOURS[..., :components])


def test_displacements_of_nifti_turn_as_in_itk(tmp_path):
    values = np.moveaxis(VECTORS, -1, 0)[:, None]  # components, time, z, y, x
    source = as_nifti(RIGHT, values)
    source.header.set_intent("displacement vector")
    nibabel.save(source, tmp_path / "x.nii")
    expected = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(tmp_path / "x.nii")))
    assert not np.array_equal(expected, VECTORS)
    image = io.read_dataset(tmp_path / "x.nii")
    np.testing.assert_array_equal(scalars(image), expected.reshape(504, 3))
    io.write_dataset(image, tmp_path / "y.nii")
    np.testing.assert_array_equal(np.asarray(nibabel.load(tmp_path / "y.nii").dataobj).T, values)


def nrrd_vectors(kind, more):
    content = nrrd_bytes("RAS", RIGHT, VECTORS, more)
    for old, new in (
        (b"dimension: 3", b"dimension: 4"),
        (b"sizes: ", b"sizes: 3 "),
        (b"directions: ", b"directions: none "),
        (b"kinds: ", f"kinds: {kind} ".encode()),
        (b"type: float32", b"type: float"),
    ):
        content = content.replace(old, new, 1)
    return content


@pytest.mark.parametrize("kind", ["vector", "covariant-vector", "3-color", "list"])
def test_vectors_of_nrrd_turn_if_their_frame_is_known(tmp_path, kind):
    frame = "measurement frame: (0,1,0) (-1,0,0) (0,0,1)\n"
    to_space = np.array([(0, 1, 0), (-1, 0, 0), (0, 0, 1)]).T  # columns are the three vectors
    (tmp_path / "x.nrrd").write_bytes(nrrd_vectors(kind, frame))
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
    (tmp_path / "x.nrrd").write_bytes(nrrd_vectors(kind, ""))
    values = scalars(io.read_dataset(tmp_path / "x.nrrd"))
    np.testing.assert_array_equal(values, VECTORS.reshape(504, 3))


WORDS = [("right", "left"), ("anterior", "posterior"), ("superior", "inferior")]


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
    wanted = f"\nspace: {space or 'left-posterior-superior'}\n"
    assert wanted.encode() in (tmp_path / "y.nrrd").read_bytes()


@pytest.mark.parametrize(
    "space", ["right-anterior-superior-time", "RAST", "scanner-xyz-time", "up"]
)
def test_other_spaces_are_refused(tmp_path, space):
    content = nrrd_bytes("RAS", RIGHT).replace(b"space: RAS", f"space: {space}".encode())
    (tmp_path / "x.nrrd").write_bytes(content)
    with pytest.raises(ValueError, match=rf"x\.nrrd` .* its space `{space}` is not one of three"):
        io.read_dataset(tmp_path / "x.nrrd")


def test_key_value_pairs_and_fields_stay(tmp_path):
    more = 'content: a: b\nspace units: "mm" "mm" "mm"\nkey:=value: and := more\nName:=\u00e4\\n\n'
    (tmp_path / "x.nrrd").write_bytes(nrrd_bytes("RAS", RIGHT, more=more))
    image = io.read_dataset(tmp_path / "x.nrrd")
    assert provenance.kept(image, provenance.NRRD_HEADER) == tuple(more.splitlines())
    for step in (1, 2):
        io.write_dataset(image, tmp_path / f"y{step}.nrrd")
        header = (tmp_path / f"y{step}.nrrd").read_bytes().partition(b"\n\n")[0].decode()
        assert set(more.splitlines()) <= set(header.splitlines())
        image = io.read_dataset(tmp_path / f"y{step}.nrrd")
    io.write_dataset(image, tmp_path / "x.vti")  # on the way through VTK's own format, too
    io.write_dataset(io.read_dataset(tmp_path / "x.vti"), tmp_path / "z.nrrd")
    assert (tmp_path / "z.nrrd").read_bytes() == (tmp_path / "y2.nrrd").read_bytes()


@pytest.mark.parametrize("suffix", [".mha", ".nii.gz"])
def test_gzip_in_several_members(tmp_path, suffix):
    """As bgzip and pigz make it."""
    if suffix == ".mha":
        SimpleITK.WriteImage(as_itk(RIGHT), str(tmp_path / "x.mha"), useCompression=True)
        assert b"CompressedData = True" in (tmp_path / "x.mha").read_bytes()
    else:
        nibabel.save(as_nifti(RIGHT), tmp_path / "x.nii")
        content = (tmp_path / "x.nii").read_bytes()
        parts = content[:100], content[100:400], content[400:]
        (tmp_path / "x.nii.gz").write_bytes(b"".join(map(gzip.compress, parts)))
    image = io.read_dataset(tmp_path / f"x{suffix}")
    np.testing.assert_array_equal(scalars(image), VALUES.ravel())


META = """ObjectType = Image
NDims = 3
DimSize = 9 8 7
ElementType = MET_SHORT
Offset = 1 2 3
ElementSpacing = 2 3 4
AnatomicalOrientation = RAI
"""


@pytest.mark.parametrize(
    ("header", "data"),
    [
        (
            "BinaryDataByteOrderMSB = True\nElementDataFile = LOCAL\n",
            VALUES.astype(">i2").tobytes(),
        ),
        (
            "BinaryData = False\nElementDataFile = x.raw\n",
            " ".join(map(str, VALUES.flat)).encode() + b"\n",
        ),
        ("HeaderSize = 5\nElementDataFile = x.raw\n", b"12345" + VALUES.tobytes()),
        ("HeaderSize = -1\nElementDataFile = sub/x.raw\n", b"123" + VALUES.tobytes()),
        ("ElementDataFile = LIST\nx0.raw\nx1.raw\nx2.raw\nx3.raw\nx4.raw\nx5.raw\nx6.raw\n", None),
        ("ElementDataFile = x%d.raw 0 6 1\n", None),
    ],
    ids=["big-endian", "text", "skip", "at the end", "list", "pattern"],
)
def test_metaimage_of_every_kind(tmp_path, header, data):
    local = data if "LOCAL" in header else b""
    path = tmp_path / ("x.mha" if local else "x.mhd")
    path.write_bytes((META + header).encode() + local)
    (tmp_path / "sub").mkdir()
    for name in ("x.raw", "sub/x.raw"):
        (tmp_path / name).write_bytes(data or b"")
    for number, part in enumerate(VALUES):
        (tmp_path / f"x{number}.raw").write_bytes(part.tobytes())
    image = io.read_dataset(path)
    np.testing.assert_array_equal(scalars(image), VALUES.ravel())
    assert (image.GetOrigin(), image.GetSpacing()) == ((1, 2, 3), (2, 3, 4))
    itk = SimpleITK.ReadImage(str(path))
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(itk), VALUES)


@pytest.mark.parametrize("name", ["{}/secret.raw", "../secret.raw", "sub/../../secret.raw"])
@pytest.mark.parametrize("suffix", [".mhd", ".nhdr"])
@pytest.mark.parametrize("how", ["{}", "LIST\n{}"])
def test_data_outside_of_the_folder_is_not_read(tmp_path, name, suffix, how):
    (tmp_path / "here" / "sub").mkdir(parents=True)
    (tmp_path / "secret.raw").write_bytes(VALUES.tobytes())
    name = how.format(name.format(tmp_path))
    if suffix == ".mhd":
        text = f"{META}ElementDataFile = {name}\n"
    else:
        text = "NRRD0004\ntype: short\ndimension: 3\nsizes: 9 8 7\nencoding: raw\nendian: little\n"
        text += f"data file: {name}\n"
    path = tmp_path / "here" / f"x{suffix}"
    path.write_text(text)
    expected = "not in its own folder|in several files"
    with pytest.raises(ValueError, match=rf"x\{suffix}` .*({expected})"):
        io.read_dataset(path)
    path.write_text(text.replace(name, "data.raw"))  # inside it is
    (tmp_path / "here" / "data.raw").write_bytes(VALUES.tobytes())
    np.testing.assert_array_equal(scalars(io.read_dataset(path)), VALUES.ravel())


def _nifti_header(size, **changes):
    header = nibabel.Nifti2Header()
    header.set_data_shape(size)
    header["vox_offset"], header["magic"] = 544, b"n+2\0\r\n\x1a\n"
    for name, value in changes.items():
        header[name] = value
    return header.binaryblock + bytes(4)


LIE = 10**6
XML = (
    '<?xml version="1.0"?><VTKFile type="ImageData" version="0.1" byte_order="LittleEndian"><ImageD'
    'ata WholeExtent="{0}" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="{0}"><PointData Scalars='
    '"a"><DataArray type="Float64" Name="a" format="ascii">1 2 3</DataArray></PointData></Piece></'
    "ImageData></VTKFile>"
)
NRRD_LIE = (
    "NRRD0004\ntype: double\ndimension: 3\nsizes: {0} {0} {0}\nendian: little\nencoding: {1}\n\n"
    "1 2 3"
)
LIES = {
    "x.mha": META.replace("9 8 7", f"{LIE} {LIE} {LIE}") + "ElementDataFile = LOCAL\n123",
    "zip.mha": META.replace("9 8 7", f"{LIE} {LIE} {LIE}")
    + "CompressedData = True\nElementDataFile = LOCAL\n123",
    "x.mhd": META.replace("9 8 7", f"{LIE} {LIE} {LIE}") + "ElementDataFile = x.mhd\n",
    "channels.mha": META + f"ElementNumberOfChannels = {LIE**3}\nElementDataFile = LOCAL\n123",
    "x.nii": _nifti_header((LIE, LIE, LIE)),
    "x.nii.gz": gzip.compress(_nifti_header((LIE, LIE, LIE))),
    "x.vti": XML.format(f"0 {LIE} 0 {LIE} 0 {LIE}"),
    "small.vti": XML.format("0 999 0 999 0 999"),
    "x.vtk": "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n"
    f"DIMENSIONS {LIE} {LIE} {LIE}\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA {LIE**3}\n"
    "SCALARS a double\nLOOKUP_TABLE default\n1 2 3\n",
    **{f"{how}.nrrd": NRRD_LIE.format(LIE, how) for how in ("raw", "gzip", "bzip2", "ascii")},
}
READ = """
import resource, sys
from vtk_mls import io
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
for name in sys.argv[1:]:
    try:
        io.read_dataset(name)
    except ValueError as error:
        print(error)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


def test_headers_that_promise_too_much(tmp_path):
    for name, content in LIES.items():
        data = content.encode() if isinstance(content, str) else content
        (tmp_path / name).write_bytes(data)
    names = [str(tmp_path / name) for name in LIES]
    command = [sys.executable, "-c", READ, *names]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    *errors, kilobytes = done.stdout.splitlines()
    assert len(errors) == len(names)
    for name, error in zip(names, errors):
        assert f"`{name}`" in error
        assert len(error) < len(name) + 200
        # not only because there is too little memory here
        assert name.endswith((".vti", ".vtk")) or "expected" in error
    assert int(kilobytes) < 100_000


def test_real_extents_are_not_taken_for_lies(tmp_path):
    """However well values can be packed."""
    image = io.read_dataset(_written(tmp_path / "x.mha", np.zeros((50, 60, 70), np.uint8)))
    io.write_dataset(image, tmp_path / "x.vti")
    assert (tmp_path / "x.vti").stat().st_size < 10_000
    assert io.read_dataset(tmp_path / "x.vti").GetNumberOfPoints() == 210_000
    for suffix in (".nii.gz", ".nrrd"):
        io.write_dataset(image, tmp_path / f"x{suffix}")
        assert io.read_dataset(tmp_path / f"x{suffix}").GetNumberOfPoints() == 210_000


def _written(path, values):
    SimpleITK.WriteImage(SimpleITK.GetImageFromArray(values), str(path))
    return path


@pytest.mark.parametrize("suffix", [".mha", ".mhd", ".nrrd", ".nhdr", ".nii", ".nii.gz", ".vti"])
def test_truncated_files(tmp_path, suffix, rng):
    values = rng.integers(0, 1000, (7, 8, 9)).astype(np.int16)
    image = io.read_dataset(_written(tmp_path / "s.mha", values))
    io.write_dataset(image, tmp_path / f"x{suffix}")
    data = {".mhd": "x.raw", ".nhdr": "x.raw.gz"}.get(suffix, f"x{suffix}")
    content = (tmp_path / data).read_bytes()
    end = 60 if suffix == ".vti" else 12  # XML may lack its last words
    for size in (0, 10, 100, 400, len(content) // 2, len(content) - end):
        (tmp_path / data).write_bytes(content[:size])
        with pytest.raises(ValueError, match=rf"x\{suffix}`"):
            io.read_dataset(tmp_path / f"x{suffix}")


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (_nifti_header((9, 8, 7, 3)), "is a series of 3 volumes; give one volume"),
        (_nifti_header((9, 8, 7, 1, 1, 2)), "more than one axis of components"),
        (_nifti_header((9, 8, 7), magic=b"ni2\0"), "give the one whose name ends in .hdr"),
        (_nifti_header((9, 8, 7), magic=b""), "Analyze 7.5 does not say where left and right are"),
        (_nifti_header((9, 8, 7), datatype=32), "the datatype 32 are not known"),
        (_nifti_header((9, 8, 7), datatype=1), "the datatype 1 are not known"),
        (_nifti_header((9, 0, 7)), "dimensions must be 1 to 7 positive numbers"),
        (_nifti_header((9, 8, 7))[:300], "its header must have 540 bytes, got 300"),
        (bytes(600), "it is no NIfTI file"),
    ],
)
def test_nifti_that_is_refused(tmp_path, content, sentence):
    (tmp_path / "x.nii").write_bytes(content)
    with pytest.raises(ValueError, match=rf"x\.nii` .*{sentence}"):
        io.read_dataset(tmp_path / "x.nii")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("NDims = 3", "NDims = 4", "up to three dimensions, got 4"),
        ("9 8 7", "9 8", "DimSize must be 3 positive numbers"),
        ("9 8 7", "9 -8 7", "DimSize must be 3 positive numbers"),
        ("MET_SHORT", "MET_OTHER", "type `MET_OTHER` are not known"),
        ("ElementType", "ElementTyp", "it has no ElementType"),
        ("LOCAL", "none.raw", "there is no data file `.*none.raw`"),
        ("LOCAL", "x%999999999d.raw 1 2", "there is no data file"),
        ("LOCAL", "x%d.raw 1 9999999", "in a few files, got 9999999"),
        ("Offset", "ElementNumberOfChannels = 0\nOffset", "Channels must be positive, got 0"),
        ("ElementDataFile", "CompressedData = True\nElementDataFile", "cannot be unpacked"),
        ("2 3 4", "2 3", "its ElementSpacing must have 3 numbers, got 2"),
    ],
)
def test_metaimage_that_is_refused(tmp_path, old, new, sentence):
    text = (META + "ElementDataFile = LOCAL\n").replace(old, new)
    (tmp_path / "x.mha").write_bytes(text.encode() + VALUES.tobytes())
    with pytest.raises(ValueError, match=rf"x\.mha` .*{sentence}"):
        io.read_dataset(tmp_path / "x.mha")


def test_handles_far_from_an_image_name_both_files(tmp_path, capsys):
    source = as_itk(RIGHT)
    source.SetOrigin((4e9, 0, 0))
    SimpleITK.WriteImage(source, str(tmp_path / "x.mha"))
    (tmp_path / "h.csv").write_text("0,0,0,1,0,0\n")
    arguments = ["x.mha", "h.csv", "out.mha"]
    assert main(["deform", *(str(tmp_path / name) for name in arguments)]) == 1
    assert re.search(r"h\.csv` must be where the data of `.*x\.mha` are", capsys.readouterr().err)


def test_field_data_cannot_change_what_a_nrrd_header_says(tmp_path):
    image = io.read_dataset(_written(tmp_path / "x.mha", VALUES))
    lines = ["data file: /etc/passwd", "encoding: raw", "a:=b\n\nc", "content: d\nsizes: 1 1 1"]
    provenance.keep(image, provenance.NRRD_HEADER, lines)
    io.write_dataset(image, tmp_path / "x.nrrd")
    back = io.read_dataset(tmp_path / "x.nrrd")
    np.testing.assert_array_equal(scalars(back), VALUES.ravel())
    kept = provenance.kept(back, provenance.NRRD_HEADER)
    assert kept == ("content: d\\nsizes: 1 1 1", "a:=b\\n\\nc")


def test_active_vectors_are_vectors_in_nrrd(tmp_path):
    source = SimpleITK.GetImageFromArray(VECTORS, isVector=True)
    SimpleITK.WriteImage(source, str(tmp_path / "x.mha"))
    image = io.read_dataset(tmp_path / "x.mha")
    image.GetPointData().SetActiveVectors("MetaImage")
    io.write_dataset(image, tmp_path / "x.nrrd")
    assert b"\nkinds: vector domain" in (tmp_path / "x.nrrd").read_bytes()
    back = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(tmp_path / "x.nrrd")))
    np.testing.assert_array_equal(back, VECTORS)
    assert io.read_dataset(tmp_path / "x.nrrd").GetPointData().GetVectors() is not None


@pytest.mark.parametrize("centers", ["", "centers: node node node\n", "centers: cell node cell\n"])
def test_a_nrrd_without_directions_begins_where_itk_sees_it(tmp_path, centers):
    header = (
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 9 8 7\nspacings: 2 3 4\naxis mins: 5 6 7\n"
        f"{centers}endian: little\nencoding: raw\n\n"
    )
    (tmp_path / "x.nrrd").write_bytes(header.encode() + VALUES.tobytes())
    itk = SimpleITK.ReadImage(str(tmp_path / "x.nrrd"))
    image = io.read_dataset(tmp_path / "x.nrrd")
    assert image.GetOrigin() == itk.GetOrigin()
    assert image.GetSpacing() == itk.GetSpacing() == (2, 3, 4)
