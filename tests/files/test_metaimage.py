"""MetaImage files: layouts of the data, other keys, and files that are refused."""

import numpy as np
import pytest
import SimpleITK
from file_fixtures import META, SMALL, VALUES, scalars

from vtk_mls import io


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
    (tmp_path / "x.mha").write_bytes(text.encode() + VALUES.tobytes())
    with pytest.raises(ValueError, match=rf"x\.mha` cannot be used: .*{sentence}"):
        io.read_dataset(tmp_path / "x.mha")


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
