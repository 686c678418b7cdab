"""What headers of images say beside the values: units, places, other spellings, other keys."""

import nibabel
import nrrd
import numpy as np
import pytest
import SimpleITK
from command_fixtures import run
from test_image_formats import in_lps, matrix
from test_io import scalars
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import io
from vtk_mls.base.messages import message_handlers
from vtk_mls.cli import main
from vtk_mls.files import field_files
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

VALUES = np.arange(7 * 6 * 5, dtype="<i2").reshape(7, 6, 5)  # z, y, x
UNITS = {"meter": 1000, "mm": 1, "micron": 0.001, "unknown": 1}
AFFINE = np.array([[0, -2, 0, 30], [3, 0, 0, -20], [0, 0, 4, 10], [0, 0, 0, 1.0]])
SIZE = (5, 6, 7)


def rotated(angle, shear=0.0):
    """An affine turned about z, whose second axis leans to the first."""
    c, s = np.cos(angle), np.sin(angle)
    affine = np.array([[c, -s, 0, -20], [s, c, 0, -18], [0, 0, 1, -16], [0, 0, 0, 1]])
    affine = affine @ np.diag([2, 2, 2.5, 1])
    affine[:3, 1] += shear * affine[:3, 0]
    return affine


def write_nifti(path, qform, qform_code, sform, sform_code, unit="mm"):
    image = nibabel.Nifti1Image(VALUES.T, None)
    image.header.set_xyzt_units(unit, "msec")
    image.set_qform(qform, qform_code)
    image.set_sform(sform, sform_code)
    image.header["pixdim"][4] = 2.5
    nibabel.save(image, path)


def heard(read):
    """What `read` returns, and the warnings meanwhile."""
    sentences = []
    with message_handlers(None, sentences.append):
        return read(), sentences


def itk_matrix(path):
    image = SimpleITK.ReadImage(str(path))
    direction = np.reshape(image.GetDirection(), (3, 3))
    return np.column_stack([direction * image.GetSpacing(), image.GetOrigin()])


def field_on(image, inverse=False):
    corners = ImageGeometry.of_image(image).grid.corners()
    moved = np.array(corners)
    moved[0] += 0.1 * (corners[-1] - corners[0])
    field = MLSDisplacementField()
    field.SetInputData(0, image)
    field.SetRestPoints(corners)
    field.SetDeformedPoints(moved)
    field.SetInverse(inverse)
    assert field.Update()
    return field.GetOutput()


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


@pytest.mark.parametrize("unit", UNITS)
def test_another_grid_is_in_the_unit_of_the_file(tmp_path, unit):
    write_nifti(tmp_path / "x.nii", AFFINE, 1, AFFINE, 1, unit)
    image = io.read_dataset(tmp_path / "x.nii")
    image.SetOrigin(np.add(image.GetOrigin(), image.GetSpacing()))
    io.write_dataset(image, tmp_path / "y.nii")
    atol = 1e-5 * UNITS[unit]
    np.testing.assert_allclose(itk_matrix(tmp_path / "y.nii"), matrix(image), atol=atol)
    affine = nibabel.load(tmp_path / "y.nii").affine
    np.testing.assert_allclose(in_lps(affine) * UNITS[unit], matrix(image), atol=atol)


@pytest.mark.parametrize("shear", [0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("sform_code", [1, 2, 4])
@pytest.mark.parametrize("is_cut", [False, True])
def test_itk_opens_what_it_opened_before(tmp_path, shear, sform_code, is_cut):
    write_nifti(tmp_path / "x.nii", rotated(0.2), 1, rotated(0.2, shear), sform_code)
    expected = itk_matrix(tmp_path / "x.nii")
    image, _ = heard(lambda: io.read_dataset(tmp_path / "x.nii"))
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
def test_a_warning_says_where_itk_and_nibabel_differ(tmp_path, qform_code, sform_code, angle):
    write_nifti(tmp_path / "x.nii", rotated(0), qform_code, rotated(angle), sform_code)
    image, warnings = heard(lambda: io.read_dataset(tmp_path / "x.nii"))
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


def test_the_command_warns_once(tmp_path, caplog, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_nifti("x.nii", rotated(0), 1, rotated(0.3), 2)
    (tmp_path / "h.csv").write_text("0,0,0,1,0,0\n9,0,0,9,0,0\n0,9,0,0,9,0\n0,0,9,0,0,9\n")
    assert main(["deform", "x.nii", "h.csv", "y.nii"]) == 0
    assert [record.getMessage()[:7] for record in caplog.records] == ["`x.nii`"]


@pytest.mark.parametrize("names", [("x.nii", "y.nii"), ("x*.nii", "y.pvd")])
def test_the_shell_hears_the_warning_too(tmp_path, monkeypatch, names):
    monkeypatch.chdir(tmp_path)
    write_nifti("x.nii", rotated(0), 1, rotated(0.3), 2)
    (tmp_path / "h.csv").write_text("0,0,0,1,0,0\n9,0,0,9,0,0\n0,9,0,0,9,0\n0,0,9,0,0,9\n")
    status, _, err = run("deform", names[0], "h.csv", names[1], "--device", "reference")
    assert status == 0
    assert err.startswith("`x.nii`: its sform counts here")
    assert err.count("\n") == 1


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


NRRD = (
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 6 7\n"
    "space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
    "space origin: (7,8,9)\nendian: little\nencoding: raw\n"
)
PLAIN = (
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 6 7\nspacings: 2 3 4\naxis mins: 10 20 30\n"
    "centers: cell node cell\nendian: little\nencoding: raw\n"
)
SPELLINGS = [
    (NRRD, {"space directions": "spacedirections", "space origin": "spaceorigin"}),
    (NRRD, {"endian: little": "endian: Little"}),
    (NRRD, {"type: short": "type: signed short int"}),
    (NRRD, {"type: short": "Type: INT16_t"}),
    (NRRD, {"encoding: raw": "encoding: hex"}),
    (NRRD, {"encoding: raw": "encoding: RAW"}),
    (NRRD, {"encoding: raw": "encoding: txt"}),
    (NRRD, {"\n": "\r\n"}),
    (NRRD, {"encoding": '# a comment: of ours\nlabels: "x" "y: z" ""\nkey:=a\\nb\nencoding'}),
    (NRRD, {"encoding": "oldmin: 0\noldmax: 3\nsampleunits: m\nencoding"}),
    (NRRD, {"encoding": "kinds: Domain Space domain\nencoding"}),
    (PLAIN, {}),
    (PLAIN, {"axis mins": "axismins", "centers": "centerings"}),
    (PLAIN, {"encoding": "kinds: ??? ??? ???\nencoding"}),
]


@pytest.mark.parametrize(("header", "changes"), SPELLINGS)
def test_other_spellings_of_nrrd_are_read_as_by_itk(tmp_path, header, changes):
    for old, new in changes.items():
        header = header.replace(old, new)
    data = VALUES.tobytes()
    if "hex" in header:
        data = data.hex().encode()
    if "txt" in header:
        data = " ".join(map(str, VALUES.ravel())).encode()
    end = "\r\n" if "\r\n" in header else "\n"
    (tmp_path / "x.nrrd").write_bytes((header + end).encode() + data)
    image = io.read_dataset(tmp_path / "x.nrrd")
    itk = SimpleITK.ReadImage(str(tmp_path / "x.nrrd"))
    np.testing.assert_array_equal(scalars(image), VALUES.ravel())
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(itk), VALUES)
    np.testing.assert_allclose(matrix(image), itk_matrix(tmp_path / "x.nrrd"))


@pytest.mark.parametrize("field", ["data file", "datafile", "DATAFILE"])
@pytest.mark.parametrize(
    ("skip", "before", "after"),
    [
        *((f"{name}: 3", b"abc", b"x") for name in ("byte skip", "byteskip", "ByteSkip")),
        *((f"{name}: -1", b"abc", b"") for name in ("byte skip", "byteskip")),
        *((f"{name}: 2", b"abc\n\n", b"x") for name in ("line skip", "lineskip")),
    ],
)
def test_skips_of_detached_nrrd(tmp_path, field, skip, before, after):
    (tmp_path / "v.raw").write_bytes(before + VALUES.tobytes() + after)
    (tmp_path / "x.nhdr").write_text(f"{NRRD}{skip}\n{field}: v.raw\n")
    np.testing.assert_array_equal(scalars(io.read_dataset(tmp_path / "x.nhdr")), VALUES.ravel())
    itk = SimpleITK.ReadImage(str(tmp_path / "x.nhdr"))
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(itk), VALUES)


def in_four_dimensions(lines):
    return f"NRRD0004\ntype: float\ndimension: 4\n{lines}endian: little\nencoding: raw\n\n"


@pytest.mark.parametrize(
    ("lines", "axis"),
    [
        ("sizes: 5 6 7 3\n", 3),
        ("sizes: 5 6 7 3\nspacings: 2 3 4 0.5\n", 3),
        ("sizes: 5 6 7 3\nspacings: 2 3 4 nan\n", 3),
        ("sizes: 3 5 6 7\nspacings: nan 2 3 4\n", 0),
        ("sizes: 5 6 7 3\nkinds: ??? ??? ??? ???\n", 3),
        ("sizes: 3 5 6 7\nkinds: ??? domain domain domain\n", 0),
        ("sizes: 5 6 7 3\nkinds: domain domain domain none\n", 3),
        ("sizes: 3 5 6 7\nkinds: VECTOR Domain domain space\n", 0),
        ("sizes: 5 6 7 3\nkinds: space space space time\n", 3),
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
    content = in_four_dimensions(lines).encode() + values.T.tobytes()
    (tmp_path / "x.nrrd").write_bytes(content)
    np.testing.assert_array_equal(nrrd.read(str(tmp_path / "x.nrrd"))[0], values)
    image = io.read_dataset(tmp_path / "x.nrrd")
    assert image.GetDimensions() == SIZE
    expected = np.moveaxis(values, axis, -1).transpose(2, 1, 0, 3).reshape(-1, 3)
    np.testing.assert_array_equal(scalars(image), expected)
    has_spacing = any(digit in lines for digit in ("2 3 4", "(2,0,0)"))
    assert image.GetSpacing() == ((2, 3, 4) if has_spacing else (1, 1, 1))
    io.write_dataset(image, tmp_path / "y.nrrd")
    itk = SimpleITK.ReadImage(str(tmp_path / "y.nrrd"))
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(itk).reshape(-1, 3), expected)


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


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("endian: little\n", "", "need a field `endian`"),
        ("dimension: 3", "dimension: 4", "as many sizes as dimensions, 4, got 3"),
        ("type: short", "type: char", "`char` are not known"),
        ("encoding: raw", "encoding: hex", "non-hexadecimal|'ascii' codec"),
    ],
)
def test_nrrd_that_itk_refuses_too(tmp_path, old, new, sentence):
    content = NRRD.replace(old, new).encode() + b"\n" + VALUES.tobytes()
    (tmp_path / "x.nrrd").write_bytes(content)
    with pytest.raises(RuntimeError):
        SimpleITK.ReadImage(str(tmp_path / "x.nrrd"))
    with pytest.raises(ValueError, match=rf"x\.nrrd` is no NRRD volume .*({sentence})"):
        io.read_dataset(tmp_path / "x.nrrd")


@pytest.mark.parametrize("suffix", [".nrrd", ".nhdr"])
def test_forward_fields_are_for_modeling(tmp_path, suffix):
    image = vtkImageData()
    image.SetDimensions(4, 4, 4)
    for inverse, expected in ((False, "resampling"), (True, "modeling")):
        field = field_on(image, inverse)
        io.write_field(field, tmp_path / f"x{suffix}")
        assert nrrd.read_header(str(tmp_path / f"x{suffix}"))["displacement field type"] == expected
        grid = ImageGeometry.of_image(field).grid
        values = np.zeros((*grid.shape, 3))
        field_files.write(values, grid, tmp_path / f"y{suffix}", is_forward=inverse)
        assert nrrd.read_header(str(tmp_path / f"y{suffix}"))["displacement field type"] == expected


def test_other_keys_of_metaimage_stay(tmp_path):
    source = SimpleITK.GetImageFromArray(VALUES)
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
        np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(back), VALUES)
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


@pytest.mark.parametrize("scale", [1e-7, 1.0, 1e6])
def test_legacy_files_have_all_digits(tmp_path, scale, rng):
    image = vtkImageData()
    image.SetDimensions(5, 4, 3)
    image.SetOrigin(scale * rng.normal(size=3))
    image.SetSpacing(scale * rng.uniform(0.1, 1, size=3))
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
    image = vtkImageData()
    size, steps = list(dimensions), [1.0, 2.0, 0.5]
    size[axis], steps[axis] = 1, spacing
    image.SetExtent([i for n in size for i in (3, n + 2)])
    image.SetSpacing(steps)
    arrays.add(image.GetPointData(), "a", np.arange(float(np.prod(size))))
    image.GetPointData().SetActiveScalars("a")
    return image


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


def test_a_spacing_of_0_between_points_is_an_error():
    image = vtkImageData()
    image.SetDimensions(4, 4, 1)
    image.SetSpacing(1, 0, 1)
    with pytest.raises(ValueError, match="`spacing` must not be zero"):
        ImageGeometry.of_image(image).grid  # noqa: B018
