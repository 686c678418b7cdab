"""What image files can say, MetaImage above all: types, layouts, keys; and what they must not."""

import gzip
import subprocess
import sys

import nibabel
import numpy as np
import pytest
import SimpleITK
from file_fixtures import (
    META,
    RIGHT,
    SMALL,
    VALUES,
    as_itk,
    as_nifti,
    assert_refused,
    itk_matrix,
    limits,
    nifti_header,
    scalars,
    write_by_itk,
)
from vtk_fixtures import add_scalars, make_image

from vtk_mls import io
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays

TYPES = [f"{kind}{size}" for size in (8, 16, 32, 64) for kind in ("int", "uint")]
TYPES += ["float32", "float64"]


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


@pytest.mark.parametrize("suffix", [".nii.gz", ".nrrd", ".mha"])
def test_a_wrong_checksum_is_noticed(tmp_path, suffix):
    SimpleITK.WriteImage(as_itk(RIGHT), str(tmp_path / f"x{suffix}"), useCompression=True)
    content = bytearray((tmp_path / f"x{suffix}").read_bytes())
    content[-1 if suffix == ".mha" else -8] ^= 1
    sentence = rf"x\{suffix}` .*(incorrect data|CRC) check"
    assert_refused(tmp_path / f"x{suffix}", content, sentence)


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
    assert_refused(path, text, rf"x\{suffix}` .*(not in its own folder|in several files)")
    path.write_text(text.replace(name, "data.raw"))  # inside it is
    (tmp_path / "here" / "data.raw").write_bytes(VALUES.tobytes())
    np.testing.assert_array_equal(scalars(io.read_dataset(path)), VALUES.ravel())


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
    "x.nii": nifti_header((LIE, LIE, LIE)),
    "x.nii.gz": gzip.compress(nifti_header((LIE, LIE, LIE))),
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
    image = io.read_dataset(write_by_itk(tmp_path / "x.mha", np.zeros((50, 60, 70), np.uint8)))
    io.write_dataset(image, tmp_path / "x.vti")
    assert (tmp_path / "x.vti").stat().st_size < 10_000
    assert io.read_dataset(tmp_path / "x.vti").GetNumberOfPoints() == 210_000
    for suffix in (".nii.gz", ".nrrd"):
        io.write_dataset(image, tmp_path / f"x{suffix}")
        assert io.read_dataset(tmp_path / f"x{suffix}").GetNumberOfPoints() == 210_000


@pytest.mark.parametrize("suffix", [".mha", ".mhd", ".nrrd", ".nhdr", ".nii", ".nii.gz", ".vti"])
def test_truncated_files(tmp_path, suffix, rng):
    values = rng.integers(0, 1000, (7, 8, 9)).astype(np.int16)
    image = io.read_dataset(write_by_itk(tmp_path / "s.mha", values))
    io.write_dataset(image, tmp_path / f"x{suffix}")
    data = {".mhd": "x.raw", ".nhdr": "x.raw.gz"}.get(suffix, f"x{suffix}")
    content = (tmp_path / data).read_bytes()
    end = 60 if suffix == ".vti" else 12  # XML may lack its last words
    for size in (0, 10, 100, 400, len(content) // 2, len(content) - end):
        (tmp_path / data).write_bytes(content[:size])
        with pytest.raises(ValueError, match=rf"x\{suffix}`"):
            io.read_dataset(tmp_path / f"x{suffix}")


@pytest.mark.parametrize("components", [1, 3])
@pytest.mark.parametrize("suffix", [".nrrd", ".mha", ".nii"])
def test_flat_images_of_itk(tmp_path, suffix, components, rng):
    values = rng.normal(size=(6, 5, components)).astype("f4")
    flat = SimpleITK.GetImageFromArray(values, isVector=True)
    if components == 1:
        flat = SimpleITK.GetImageFromArray(values[..., 0])
    flat.SetSpacing((2, 3))
    flat.SetOrigin((7, 8))
    SimpleITK.WriteImage(flat, str(tmp_path / f"x{suffix}"))
    image = io.read_dataset(tmp_path / f"x{suffix}")
    assert image.GetDimensions() == (5, 6, 1)
    np.testing.assert_array_equal(scalars(image).reshape(values.shape), values)
    np.testing.assert_allclose(image.GetSpacing(), (2, 3, 1))
    np.testing.assert_allclose(image.GetOrigin(), (7, 8, 0))
    io.write_dataset(image, tmp_path / f"y{suffix}")
    back = SimpleITK.ReadImage(str(tmp_path / f"y{suffix}"))
    assert back.GetSpacing()[:2] == (2, 3)
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(back).reshape(values.shape), values)


@pytest.mark.parametrize("scale", [1e-7, 1.0, 1e6])
def test_legacy_files_have_all_digits(tmp_path, scale, rng):
    origin, spacing = scale * rng.normal(size=3), scale * rng.uniform(0.1, 1, size=3)
    image = make_image((5, 4, 3), origin=origin, spacing=spacing)
    arrays.add(image.GetPointData(), "a", rng.normal(size=60))
    arrays.add(image.GetFieldData(), "f", rng.normal(size=300))
    io.write_dataset(image, tmp_path / "x.vtk")
    back = io.read_dataset(tmp_path / "x.vtk")
    assert (back.GetOrigin(), back.GetSpacing()) == (image.GetOrigin(), image.GetSpacing())
    for get in (
        lambda data: data.GetPointData().GetArray("a"),
        lambda data: data.GetFieldData().GetArray("f"),
    ):
        np.testing.assert_array_equal(arrays.to_numpy(get(back)), arrays.to_numpy(get(image)))
    assert [path.name for path in tmp_path.iterdir()] == ["x.vtk"]


def flat_image(axis, spacing, dimensions=(6, 5, 4)):
    size, steps = list(dimensions), [1.0, 2.0, 0.5]
    size[axis], steps[axis] = 1, spacing
    image = make_image(size, (3, 3, 3), origin=(0, 0, 0), spacing=steps)
    return add_scalars(image, "a", np.arange(np.prod(size)))


@pytest.mark.parametrize("axis", range(3))
def test_flat_images_without_a_spacing(tmp_path, axis):
    rest = np.array(flat_image(axis, 0.0).GetBounds()).reshape(3, 2).T
    rest = np.array([*rest, rest.mean(axis=0)])
    deformed = rest + [[0, 0, 0], [0, 0, 0], np.eye(3)[axis - 1]]
    for algorithm in (MLSDeform(), MLSDisplacementField()):
        algorithm.SetRestPoints(rest)
        algorithm.SetDeformedPoints(deformed)
        found = []
        for spacing in (0.0, 1.0):
            image = flat_image(axis, spacing)
            image.SetOrigin(*(-3 * spacing * np.eye(3)[axis]))
            algorithm.SetInputData(0, image)
            assert algorithm.Update()
            output = algorithm.GetOutput()
            assert output.GetSpacing() == image.GetSpacing()
            found.append(np.array(scalars(output)))
        np.testing.assert_array_equal(*found)
    for name in ("x.vti", "x.vtk"):
        io.write_dataset(flat_image(axis, 0.0), tmp_path / name)
        assert io.read_dataset(tmp_path / name).GetSpacing() == flat_image(axis, 0.0).GetSpacing()
    for name in ("x.mha", "x.nrrd", "x.nii"):
        io.write_dataset(flat_image(axis, 0.0), tmp_path / name)
        assert itk_matrix(tmp_path / name)[axis, axis] in (1, -1)


# MetaImage


@pytest.mark.parametrize(
    ("header", "data"),
    [
        ("BinaryDataByteOrderMSB = True\nElementDataFile = LOCAL\n", VALUES.byteswap().tobytes()),
        (
            "BinaryData = False\nElementDataFile = x.raw\n",
            b"\n".join(b"%d" % n for n in VALUES.flat) + b"\n",
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


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("NDims = 3", "NDims = 5", "up to four dimensions, got 5"),
        ("9 8 7", "9 8", "DimSize must be 3 positive numbers"),
        ("9 8 7", "9 -8 7", "DimSize must be 3 positive numbers"),
        ("MET_SHORT", "MET_OTHER", "type `MET_OTHER` are not supported"),
        ("ElementType", "ElementTyp", "it has no ElementType"),
        ("LOCAL", "none.raw", "there is no data file `.*none.raw`"),
        ("LOCAL", "x%999999999d.raw 1 2", "there is no data file"),
        ("LOCAL", "x%d.raw 1 9999999", "in 65536 files at most, got 9999999"),
        ("Offset", "ElementNumberOfChannels = 0\nOffset", "Channels must be positive, got 0"),
        ("ElementDataFile", "CompressedData = True\nElementDataFile", "cannot be unpacked"),
        ("2 3 4", "2 3", "its ElementSpacing must have 3 numbers, got 2"),
        ("Offset", "TransformMatrix = nan 0 0 0 1 0 0 0 1\nOffset", "its steps between voxels"),
        ("Offset", "TransformMatrix = 1\nOffset", "direction must have 9 numbers, got 1"),
        ("1 2 3", "inf 2 3", "its Offset must be finite"),
        ("1 2 3", "left 2 3", "could not convert .*left"),
        ("2 3 4", "0 3 4", "its steps between voxels"),
    ],
)
def test_metaimage_that_is_refused(tmp_path, old, new, sentence):
    text = (META + "ElementDataFile = LOCAL\n").replace(old, new)
    content = text.encode() + VALUES.tobytes()
    assert_refused(tmp_path / "x.mha", content, rf"x\.mha` cannot be used: .*{sentence}")


def test_other_keys_of_metaimage_stay(tmp_path):
    source = SimpleITK.GetImageFromArray(SMALL)
    source.SetDirection((0, 1, 0, 1, 0, 0, 0, 0, -1))
    for key, text in (("Patient", "a = b: \u00e4"), ("Weight", "70")):
        source.SetMetaData(key, text)
    SimpleITK.WriteImage(source, str(tmp_path / "x.mha"))
    content = (tmp_path / "x.mha").read_bytes()
    more = b"NDims = 3\nModality = MET_MOD_CT\nComment = made by hand\nElementMin = 0\n"
    (tmp_path / "x.mha").write_bytes(content.replace(b"NDims = 3\n", more, 1))
    source = SimpleITK.ReadImage(str(tmp_path / "x.mha"))
    assert source.GetMetaData("Weight") == "70"
    image = io.read_dataset(tmp_path / "x.mha")
    for name in ("y.mha", "y.mhd"):
        io.write_dataset(image, tmp_path / name)
        back = SimpleITK.ReadImage(str(tmp_path / name))
        np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(back), SMALL)
        assert back.GetDirection() == source.GetDirection()
        assert back.GetMetaData("Modality") == "MET_MOD_CT"
        for key in ("Patient", "Weight"):
            assert back.GetMetaData(key) == source.GetMetaData(key)
        header = (tmp_path / name).read_bytes()
        assert header.count(b"Comment = made by hand\n") == header.count(b"\nNDims = 3\n") == 1
        assert b"ElementM" not in header
        assert b"AnatomicalOrientation = " in header
    image.SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1)
    io.write_dataset(image, tmp_path / "z.mha")
    assert b"AnatomicalOrientation" not in (tmp_path / "z.mha").read_bytes()
