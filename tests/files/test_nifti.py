"""NIfTI files: types, forms, units, intents, and files that are refused."""

import struct
import sys
from functools import partial

import nibabel
import numpy as np
import pytest
import SimpleITK
from command_fixtures import run
from file_fixtures import (
    COLORS,
    LEFT,
    RIGHT,
    SMALL,
    VALUES,
    VECTORS,
    as_nifti,
    assert_refused,
    field_on,
    in_lps,
    itk_matrix,
    limits,
    matrix,
    nifti_header,
    scalars,
    write_by_itk,
)

from vtk_mls import io
from vtk_mls.base.messages import message_handlers
from vtk_mls.vtk.arrays import ImageGeometry

UNITS = {"meter": 1000, "mm": 1, "micron": 0.001, "unknown": 1}
AFFINE = np.array([[0, -2, 0, 30], [3, 0, 0, -20], [0, 0, 4, 10], [0, 0, 0, 1.0]])


def rotated(angle, shear=0.0):
    """An affine turned about z, whose second axis leans to the first."""
    c, s = np.cos(angle), np.sin(angle)
    affine = np.array([[c, -s, 0, -20], [s, c, 0, -18], [0, 0, 1, -16], [0, 0, 0, 1]])
    affine = affine @ np.diag([2, 2, 2.5, 1])
    affine[:3, 1] += shear * affine[:3, 0]
    return affine


def write_nifti(path, qform, qform_code, sform, sform_code, unit="mm"):
    image = nibabel.Nifti1Image(SMALL.T, None)
    image.header.set_xyzt_units(unit, "msec")
    image.set_qform(qform, qform_code)
    image.set_sform(sform, sform_code)
    image.header["pixdim"][4] = 2.5
    nibabel.save(image, path)


def with_warnings(read):
    """What `read` returns, and the warnings meanwhile."""
    sentences = []
    with message_handlers(None, sentences.append):
        return read(), sentences


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
    values = scalars(io.read_dataset(tmp_path / "x.nii"))
    np.testing.assert_allclose(values, expected, rtol=1e-6)
    is_scaled = slope in (0.25, -2) or (slope, intercept) == (1, 10)
    assert values.dtype == (np.float32 if is_scaled and name != "float64" else np.dtype(name))


def test_a_sheared_nifti_has_no_qform(tmp_path):
    affine = np.array([[2, 0.5, 0, 3], [0, 2, 0, 4], [0, 0.25, 3, 5], [0, 0, 0, 1.0]])
    nibabel.save(nibabel.Nifti1Image(VALUES.T, affine), tmp_path / "x.nii")
    io.write_dataset(io.read_dataset(tmp_path / "x.nii"), tmp_path / "y.nii")
    back = nibabel.load(tmp_path / "y.nii")
    np.testing.assert_allclose(back.affine, affine, atol=1e-5)
    assert back.header["qform_code"] == 0


def test_a_long_nifti_is_of_version_2(tmp_path):
    values = np.arange(40_000, dtype=np.int32).reshape(1, 2, 20_000).repeat(2, axis=2)
    io.write_dataset(io.read_dataset(write_by_itk(tmp_path / "x.mha", values)), tmp_path / "x.nii")
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


def test_nifti_colors(tmp_path):
    for components, names in ((3, "RGB"), (4, "RGBA")):
        dtype = np.dtype([(name, "u1") for name in names])
        values = np.ascontiguousarray(COLORS[..., :components]).view(dtype)[..., 0]
        nibabel.save(as_nifti(RIGHT, values), tmp_path / "x.nii")
        image = io.read_dataset(tmp_path / "x.nii")
        np.testing.assert_array_equal(scalars(image), COLORS[..., :components].reshape(504, -1))
        io.write_dataset(image, tmp_path / "y.nii")
        back = nibabel.load(tmp_path / "y.nii")
        np.testing.assert_array_equal(np.asarray(back.dataobj).T, values)


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


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (nifti_header((9, 8, 7, 3)), "expected 1512 values, got 0"),
        (nifti_header((9, 8, 7, 1, 1, 2)), "more than one axis of components"),
        (nifti_header((9, 8, 7), magic=b"ni2\0"), "give the one whose name ends in .hdr"),
        (nifti_header((9, 8, 7), magic=b""), "Analyze 7.5 does not say where left and right are"),
        (nifti_header((9, 8, 7), datatype=32), "the datatype 32 are not supported"),
        (nifti_header((9, 8, 7), datatype=1), "the datatype 1 are not supported"),
        (nifti_header((9, 8, 7), datatype=258), "the datatype 258 are not supported"),
        (nifti_header((9, 0, 7)), "dimensions must be 1 to 7 positive numbers"),
        (nifti_header((9, 8, 7))[:300], "its header must have 540 bytes, got 300"),
        (bytes(600), "it is not a NIfTI file"),
    ],
)
def test_nifti_that_is_refused(tmp_path, content, sentence):
    assert_refused(tmp_path / "x.nii", content, rf"x\.nii` .*{sentence}")


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("codes", [(1, 1), (0, 2), (1, 0)])
def test_nifti_is_in_millimeters_and_goes_back_in_its_unit(tmp_path, unit, codes):
    qform_code, sform_code = codes
    write_nifti(tmp_path / "x.nii", AFFINE, qform_code, AFFINE, sform_code, unit)
    image = io.read_dataset(tmp_path / "x.nii")
    atol = 1e-5 * UNITS[unit]  # of float32
    np.testing.assert_allclose(matrix(image), in_lps(AFFINE) * UNITS[unit], atol=atol)
    np.testing.assert_allclose(matrix(image), itk_matrix(tmp_path / "x.nii"), atol=atol)
    io.write_dataset(image, tmp_path / "y.nii")
    before, after = (nibabel.load(tmp_path / name) for name in ("x.nii", "y.nii"))
    np.testing.assert_array_equal(after.affine, before.affine)
    np.testing.assert_array_equal(after.header["pixdim"], before.header["pixdim"])
    length, time = after.header.get_xyzt_units()
    assert (length, time) == ("mm" if unit == "unknown" else unit, "msec")
    io.write_dataset(image, tmp_path / "y.nrrd")
    np.testing.assert_allclose(
        itk_matrix(tmp_path / "y.nrrd"), matrix(image), atol=1e-9 * UNITS[unit]
    )
    io.write_field(field_on(image), tmp_path / "f.nii")
    np.testing.assert_allclose(itk_matrix(tmp_path / "f.nii"), matrix(image), atol=atol)
    # another grid is in the unit of the file, too
    image.SetOrigin(np.add(image.GetOrigin(), image.GetSpacing()))
    io.write_dataset(image, tmp_path / "y.nii")
    np.testing.assert_allclose(itk_matrix(tmp_path / "y.nii"), matrix(image), atol=atol)
    affine = nibabel.load(tmp_path / "y.nii").affine
    np.testing.assert_allclose(in_lps(affine) * UNITS[unit], matrix(image), atol=atol)


@pytest.mark.parametrize("shear", [0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("sform_code", [1, 2, 4])
@pytest.mark.parametrize("is_cut", [False, True])
def test_itk_opens_what_it_opened_before(tmp_path, shear, sform_code, is_cut):
    write_nifti(tmp_path / "x.nii", rotated(0.2), 1, rotated(0.2, shear), sform_code)
    expected = itk_matrix(tmp_path / "x.nii")
    image, _ = with_warnings(lambda: io.read_dataset(tmp_path / "x.nii"))
    if is_cut:
        direction = np.reshape(ImageGeometry.of_image(image).direction, (3, 3))
        image.SetOrigin(image.GetOrigin() + direction @ (2 * np.array(image.GetSpacing())))
        expected[:, 3] += expected[:, :3] @ [2, 2, 2]
    io.write_dataset(image, tmp_path / "y.nii")
    np.testing.assert_allclose(itk_matrix(tmp_path / "y.nii"), expected, atol=2e-5)
    np.testing.assert_allclose(
        nibabel.load(tmp_path / "y.nii").affine[:3],
        in_lps(np.vstack([matrix(image), [0, 0, 0, 1]])),
        atol=1e-5,
    )
    io.write_field(field_on(image), tmp_path / "f.nii")
    np.testing.assert_allclose(itk_matrix(tmp_path / "f.nii"), expected, atol=2e-5)


@pytest.mark.parametrize("qform_code", [0, 1, 2, 4])
@pytest.mark.parametrize("sform_code", [0, 1, 2, 4])
@pytest.mark.parametrize("angle", [0, 0.3])
def test_a_warning_where_itk_and_nibabel_differ(tmp_path, qform_code, sform_code, angle):
    write_nifti(tmp_path / "x.nii", rotated(0), qform_code, rotated(angle), sform_code)
    image, warnings = with_warnings(lambda: io.read_dataset(tmp_path / "x.nii"))
    expected = in_lps(nibabel.load(tmp_path / "x.nii").affine)
    np.testing.assert_allclose(matrix(image), expected, atol=1e-5)
    differs = not np.allclose(itk_matrix(tmp_path / "x.nii"), expected, atol=1e-3)
    assert len(warnings) == differs
    assert all(f"`{tmp_path / 'x.nii'}`" in sentence for sentence in warnings)
    io.write_dataset(image, tmp_path / "y.nii")
    before, after = (nibabel.load(tmp_path / name).header for name in ("x.nii", "y.nii"))
    for name in ("qform_code", "sform_code", "srow_x", "srow_y", "srow_z", "quatern_b"):
        assert before[name] == pytest.approx(after[name], abs=0)
    np.testing.assert_array_equal(before["pixdim"], after["pixdim"])


@pytest.mark.parametrize("names", [("x.nii", "y.nii"), ("x*.nii", "y.pvd")])
def test_the_shell_hears_the_warning_too(tmp_path, monkeypatch, names):
    monkeypatch.chdir(tmp_path)
    write_nifti("x.nii", rotated(0), 1, rotated(0.3), 2)
    (tmp_path / "h.csv").write_text("0,0,0,1,0,0\n9,0,0,9,0,0\n0,9,0,0,9,0\n0,0,9,0,0,9\n")
    status, _, err = run("deform", names[0], "h.csv", names[1])
    assert status == 0
    assert err.startswith("`x.nii`: its sform counts here")
    assert err.count("\n") == 1


def test_nifti_without_nibabel_is_one_sentence(tmp_path, monkeypatch):
    write_nifti(tmp_path / "x.nii", AFFINE, 1, AFFINE, 1)
    image = io.read_dataset(tmp_path / "x.nii")
    monkeypatch.setitem(sys.modules, "nibabel", None)
    for path, use in (("x.nii", io.read_dataset), ("y.nii", partial(io.write_dataset, image))):
        with pytest.raises(ValueError, match=rf"{path}` .*package nibabel: pip install nibabel"):
            use(tmp_path / path)
    io.write_dataset(image, tmp_path / "y.nrrd")


def test_a_broken_qform_beside_an_sform_does_not_count(tmp_path):
    write_nifti(tmp_path / "x.nii", AFFINE, 1, AFFINE, 2)
    content = bytearray((tmp_path / "x.nii").read_bytes())
    content[256:268] = np.full(3, 0.9, "<f4").tobytes()  # the quaternion
    (tmp_path / "x.nii").write_bytes(content)
    image = io.read_dataset(tmp_path / "x.nii")
    image.SetOrigin(np.add(image.GetOrigin(), 5))  # a place that the file does not have
    io.write_dataset(image, tmp_path / "y.nii")
    header = nibabel.load(tmp_path / "y.nii").header
    assert (header["sform_code"], header["qform_code"]) == (2, 2)
    np.testing.assert_allclose(in_lps(header.get_sform()), matrix(image), atol=1e-5)
    np.testing.assert_allclose(header.get_qform(), header.get_sform(), atol=1e-5)
