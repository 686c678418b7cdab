"""Transforms in files: SimpleITK, nitransforms and 3D Slicer move points and images as we do."""

import sys
from pathlib import Path

import nibabel
import nitransforms
import numpy as np
import pytest
import SimpleITK as sitk
import slicer_peer
from file_fixtures import DIRECTIONS, IMAGES, handles_on, transform_by_itk
from nitransforms.resampling import apply

from vtk_mls import Affine, Chain, Deformation, Field, Grid, io
from vtk_mls.files import field_files

ITK = (".h5", ".hdf5", ".tfm", ".txt")
SPACING = (0.9, 1.0, 1.1)
TO_RAS = [-1, -1, 1]
MATRIX = np.array([[1.1, 0.2, -0.1, 3], [-0.3, 0.9, 0.2, -4], [0.1, -0.2, -1.2, 5], [0, 0, 0, 1]])
CENTER = (12.0, -34.0, 56.0)


@pytest.fixture(params=DIRECTIONS)
def grid(request, tmp_path, monkeypatch):
    """An oblique grid; the test's folder is the current one."""
    monkeypatch.chdir(tmp_path)
    return Grid((18, 17, 16), (20, -30, 40), SPACING, DIRECTIONS[request.param])


@pytest.fixture
def deformation(grid):
    """It also stretches and shifts all, so that its affine part is not small."""
    rest, deformed = handles_on(grid)
    middle = rest.mean(axis=0)
    return Deformation(rest, (deformed - middle) * (1.3, 1.1, 0.9) + middle + 1, device="reference")


@pytest.fixture
def on_grid(grid, rng):
    """1,000 points of the grid."""
    return grid.points_of(rng.choice(grid.size, 1000, replace=False))


@pytest.fixture
def between(grid, rng):
    """1,000 points between those of the grid."""
    return grid.at(rng.uniform(0, 1, (1000, 3)) * (np.array(grid.dimensions) - 1))


def moved_by(transform, points):
    """Points moved by a transform of SimpleITK."""
    return np.array([transform.TransformPoint(point) for point in points.tolist()])


def random_field(grid, rng):
    return rng.normal(size=(*grid.shape, 3)).astype(np.float32)


def itk_image(values, grid):
    image = sitk.GetImageFromArray(np.asarray(values, np.float64), isVector=values.ndim == 4)
    image.SetOrigin(grid.origin.tolist())
    image.SetSpacing(grid.spacing.tolist())
    image.SetDirection(grid.direction.ravel().tolist())
    return image


def ras_of(grid):
    """The matrix from indices to RAS."""
    affine = np.column_stack([grid.index_to_world, grid.origin]) * np.reshape(TO_RAS, (3, 1))
    return np.vstack([affine, [0, 0, 0, 1]])


def smooth_values(grid):
    x, y, z = (grid.points() - grid.corners().mean(axis=0)).T
    return (9 * np.sin(x / 3) + 2 * y + z * z / 4).reshape(grid.shape)


def assert_resampled(theirs, deformation, values, grid):
    """Their image is ours where the source is inside; beyond, programs differ."""
    (ours,) = deformation.resample([values], grid)
    source = grid.index_of(deformation.backward(grid.points()))
    inside = ((source > 0.01) & (source < np.array(grid.dimensions) - 1.01)).all(axis=1)
    assert inside.mean() > 0.3
    difference = np.abs(theirs - ours).ravel()[inside]
    assert difference.max() < 1e-3 * np.ptp(values)
    assert np.abs(ours - values).ravel()[inside].max() > 0.1 * np.ptp(values)


@pytest.mark.parametrize("suffix", [*ITK, *IMAGES])
def test_simpleitk_moves_points_and_images_as_we_do(grid, deformation, on_grid, between, suffix):
    io.write_transform(deformation, f"x{suffix}", grid)
    transform = transform_by_itk(f"x{suffix}")
    field = Field(deformation.displacement_field(grid).displacement, grid)
    tolerance = 1e-3 * min(SPACING)
    np.testing.assert_allclose(
        moved_by(transform, on_grid), deformation.backward(on_grid), rtol=0, atol=tolerance
    )
    np.testing.assert_allclose(
        moved_by(transform, between), field.backward(between), rtol=0, atol=tolerance
    )
    read = io.read_transform(f"x{suffix}")
    outside = grid.at([[-9, 3, 4], [40, 50, 60]])
    for points in (between, outside):
        np.testing.assert_allclose(
            read.backward(points), moved_by(transform, points), rtol=0, atol=1e-5
        )
    values = smooth_values(grid)
    image = itk_image(values, grid)
    resampled = sitk.Resample(image, image, transform, sitk.sitkLinear)
    assert_resampled(sitk.GetArrayFromImage(resampled), deformation, values, grid)


def test_outside_of_the_grid_the_best_affine_map_goes_on(grid, deformation, rng):
    io.write_transform(deformation, "x.h5", grid)
    v, far = grid.points(), grid.at(rng.uniform(100, 200, (50, 3)))
    best = np.linalg.lstsq(np.column_stack([v, np.ones(len(v))]), deformation.backward(v))[0]
    expected = far @ best[:3] + best[3]
    np.testing.assert_allclose(moved_by(sitk.ReadTransform("x.h5"), far), expected, atol=1e-3)
    assert np.abs(expected - far).max() > 10


def test_a_map_that_flattens_everything_has_no_affine_part(grid, between):
    v = grid.points()
    displacement = (v * [1, 1, 0] - v).reshape(*grid.shape, 3)
    field_files.write(displacement, grid, "x.tfm")
    transform = sitk.ReadTransform("x.tfm")
    np.testing.assert_allclose(moved_by(transform, between), between * [1, 1, 0], atol=1e-4)


@pytest.mark.parametrize("suffix", [*ITK, ".mat"])
@pytest.mark.parametrize("transform", [Affine(MATRIX), Chain([Affine(MATRIX)] * 2)])
def test_affine_transforms_are_exact(grid, between, suffix, transform):
    path = f"x{suffix}"
    io.write_transform(transform, path, grid)
    ours = transform.backward(between)
    np.testing.assert_allclose(moved_by(sitk.ReadTransform(path), between), ours, atol=1e-12)
    read = io.read_transform(path)
    assert isinstance(read, Affine)
    np.testing.assert_allclose(read.backward(between), ours, atol=1e-12)
    if suffix != ".hdf5":  # which nitransforms does not read
        theirs = nitransforms.linear.load(path, fmt="itk").map(between * TO_RAS) * TO_RAS
        np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-4)  # it reads float32


@pytest.mark.parametrize("suffix", ITK)
def test_chains_of_affine_transforms_and_fields_are_written_as_they_are(grid, between, rng, suffix):
    field = Field(random_field(grid, rng), grid)
    other = Field(random_field(grid, rng), Grid(grid.dimensions, (15, -28, 44), (2, 1, 1.5)))
    chain = Chain([Affine(MATRIX), Chain([field, other])])
    io.write_transform(chain, f"x{suffix}")
    ours = chain.backward(between)
    np.testing.assert_allclose(moved_by(sitk.ReadTransform(f"x{suffix}"), between), ours, atol=1e-9)
    read = io.read_transform(f"x{suffix}")
    assert [type(part) for part in read.transforms] == [Affine, Field, Field]
    np.testing.assert_array_equal(read.transforms[1].displacement, field.displacement)
    np.testing.assert_allclose(read.backward(between), ours, atol=1e-9)


@pytest.mark.parametrize(
    ("path", "read"),
    [
        ("x.h5", nitransforms.manip.load),
        ("x.nii.gz", nitransforms.nonlinear.DenseFieldTransform.from_filename),
    ],
)
def test_nitransforms_moves_points_and_images_as_we_do(grid, deformation, on_grid, path, read):
    io.write_transform(deformation, path, grid, convention="ants")
    transform = read(path, fmt="itk")
    moved = transform.map(on_grid * TO_RAS) * TO_RAS
    tolerance = 1e-3 * min(SPACING)
    np.testing.assert_allclose(moved, deformation.backward(on_grid), rtol=0, atol=tolerance)
    values = smooth_values(grid)
    image = nibabel.Nifti1Image(values.T, ras_of(grid))
    theirs = apply(transform, image, reference=image, order=1).get_fdata().T
    assert_resampled(theirs, deformation, values, grid)


@pytest.mark.parametrize(
    ("convention", "code", "signs"), [("itk", 1006, TO_RAS), ("ants", 1007, [1, 1, 1])]
)
def test_conventions_of_nifti(grid, rng, between, convention, code, signs):
    field = Field(random_field(grid, rng), grid)
    io.write_transform(field, "x.nii", convention=convention)
    image = nibabel.load("x.nii")
    assert int(image.header["intent_code"]) == code
    vectors = np.asarray(image.dataobj)[:, :, :, 0].transpose(2, 1, 0, 3)
    np.testing.assert_array_equal(vectors, field.displacement * np.float32(signs))
    read = io.read_transform("x.nii")
    np.testing.assert_array_equal(read.displacement, field.displacement)
    np.testing.assert_allclose(read.grid.points(), grid.points(), atol=1e-5)
    theirs = moved_by(transform_by_itk("x.nii"), between)
    np.testing.assert_allclose(theirs, read.backward(between), atol=1e-5)


def saved_with_intent(name, values, to_ras, code, intent_name, *parameters):
    image = nibabel.Nifti1Image(values, to_ras)
    image.header["intent_code"], image.header["intent_name"] = code, intent_name
    for number, parameter in enumerate(parameters, 1):
        image.header[f"intent_p{number}"] = parameter
    nibabel.save(image, name)


@pytest.mark.parametrize("code", [1006, 1007])
@pytest.mark.parametrize(
    ("name", "number", "has_positions"),
    [("NREG_TRANS", 0, True), ("NREG_TRANS", 1, False), ("Mapping", 0, True)],
)
def test_fields_of_niftyreg_and_spm_are_distinguished(grid, rng, code, name, number, has_positions):
    """Their vectors are in RAS: displacements, or the positions that voxels come from."""
    field, to_ras = random_field(grid, rng), ras_of(grid)
    vectors = field.transpose(2, 1, 0, 3) * TO_RAS
    indices = np.indices(grid.dimensions).transpose(1, 2, 3, 0)
    if has_positions:
        vectors = vectors + indices @ to_ras[:3, :3].T + to_ras[:3, 3]
    saved_with_intent("x.nii.gz", vectors[:, :, :, None], to_ras, code, name, number)
    read = io.read_transform("x.nii.gz")
    np.testing.assert_allclose(read.displacement, field, rtol=0, atol=1e-4)
    image = io.read_dataset("x.nii.gz")
    io.write_dataset(image, "y.nii.gz")  # as an image it keeps what it says
    header = nibabel.load("y.nii.gz").header
    assert (header["intent_name"].item().decode(), header["intent_p1"]) == (name, number)


@pytest.mark.parametrize(
    ("code", "name", "number", "sentence"),
    [
        (1007, "NREG_TRANS", 2, "it has control points of a cubic B-spline of NiftyReg; expected"),
        (1007, "NREG_TRANS", 3, "it has velocities as positions of NiftyReg"),
        (1007, "NREG_TRANS", 4, "it has velocities of NiftyReg"),
        (1007, "NREG_TRANS", 5, "it has control points of velocities of NiftyReg"),
        (1007, "NREG_TRANS", 6, "it has control points of a linear spline of NiftyReg"),
        (1007, "NREG_TRANS", 9, "it has the unknown content 9 of NiftyReg"),
        (2006, "", 0, "it has displacements of FSL, in coordinates of FSL's images; expected disp"),
        (2007, "", 0, "it has coefficients or a field map of FSL"),
        (2018, "", 0, "it has coefficients or a field map of FSL"),
    ],
)
def test_what_is_no_displacement_is_named(grid, rng, code, name, number, sentence):
    values = random_field(grid, rng).transpose(2, 1, 0, 3)
    for shaped in (values, values[:, :, :, None]):  # FSL's are volumes in time
        saved_with_intent("x.nii", shaped, ras_of(grid), code, name, number)
        with pytest.raises(ValueError, match=rf"^`x\.nii` cannot be used: {sentence}"):
            io.read_transform("x.nii")


def linear_transforms():
    """SimpleITK's linear transforms, most with a center."""
    euler = sitk.Euler3DTransform(CENTER, 0.1, -0.2, 0.3, (4, 5, 6))
    affine = sitk.AffineTransform(MATRIX[:3, :3].ravel().tolist(), (1, 2, 3), CENTER)
    similarity = sitk.Similarity3DTransform(1.3, (0, 0.6, 0.8), 0.5, (1, 2, 3), CENTER)
    scaling = sitk.ScaleTransform(3, (1, 2, 3))
    scaling.SetCenter(CENTER)
    versor = sitk.VersorRigid3DTransform((0, 0.6, 0.8), 0.5, (1, 2, 3), CENTER)
    translation = sitk.TranslationTransform(3, (1, 2, 3))
    return [euler, affine, similarity, scaling, versor, translation, sitk.Transform()]


@pytest.mark.parametrize("suffix", [*ITK, ".mat"])
@pytest.mark.parametrize("transform", linear_transforms(), ids=lambda t: t.GetName())
def test_linear_transforms_of_simpleitk(grid, between, suffix, transform):
    sitk.WriteTransform(transform, f"x{suffix}")
    read = io.read_transform(f"x{suffix}")
    assert isinstance(read, Affine)
    np.testing.assert_allclose(read.backward(between), moved_by(transform, between), atol=1e-12)
    moved = read.forward(between)
    np.testing.assert_allclose(moved_by(transform, moved), between, atol=1e-12)


@pytest.mark.parametrize("suffix", ITK)
def test_composites_of_simpleitk(grid, between, rng, suffix):
    image = itk_image(random_field(grid, rng), grid)
    composite = sitk.CompositeTransform(
        [*linear_transforms()[:1], sitk.DisplacementFieldTransform(image), linear_transforms()[2]]
    )
    sitk.WriteTransform(composite, f"x{suffix}")
    read = io.read_transform(f"x{suffix}")
    theirs = moved_by(composite, between)
    np.testing.assert_allclose(read.backward(between), theirs, atol=1e-5)
    linear = sitk.CompositeTransform(linear_transforms())
    sitk.WriteTransform(linear, f"x{suffix}")
    read = io.read_transform(f"x{suffix}")
    assert isinstance(read, Affine)
    np.testing.assert_allclose(read.backward(between), moved_by(linear, between), atol=1e-10)


@pytest.mark.parametrize("suffix", IMAGES)
def test_fields_of_simpleitk(grid, between, rng, suffix):
    sitk.WriteImage(itk_image(random_field(grid, rng), grid), f"x{suffix}")
    read = io.read_transform(f"x{suffix}")
    theirs = moved_by(transform_by_itk(f"x{suffix}"), between)
    np.testing.assert_allclose(read.backward(between), theirs, atol=1e-5)
    assert np.abs(theirs - between).max() > 1


@slicer_peer.needs_slicer
@pytest.mark.parametrize("suffix", [".h5", ".tfm"])
def test_slicer_reads_composites(grid, deformation, suffix):
    io.write_transform(deformation, f"field{suffix}", grid)
    io.write_transform(Affine(MATRIX), f"affine{suffix}")
    points = grid.at([[5, 6, 7], [9, 8, 8], [12, 10, 4]])
    (field, _), (affine, _) = slicer_peer.moved(points, [f"field{suffix}", f"affine{suffix}"])
    np.testing.assert_allclose(field, deformation.backward(points), atol=1e-4)
    np.testing.assert_allclose(affine, Affine(MATRIX).backward(points), atol=1e-9)


HEAD = "#Insight Transform File V1.0\n#Transform 0\nTransform: "
ROWS = "Parameters: 1 0 0 0 1 0 0 0 {} 1 2 3\nFixedParameters: 0 0 0\n"
AFFINE = f"{HEAD}AffineTransform_double_3_3\n{ROWS}"


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("x.tfm", "", "it is not an ITK transform file"),
        ("x.txt", "1,2,3,4,5,6", "it is not an ITK transform file"),
        ("x.h5", "nothing", "it is not an ITK transform file"),
        ("x.mat", "nothing", "it is not an ITK transform file"),
        ("x.tfm", AFFINE.format(0), "its matrix must be invertible"),
        ("x.tfm", AFFINE.format("nan"), "ITK says: Error setting parameters"),
        (
            "x.tfm",
            HEAD + "FooTransform_double_3_3\n" + ROWS.format(1),
            "ITK says: Could not create",
        ),
        (
            "x.tfm",
            AFFINE.format(1) + AFFINE.format(2).partition("\n")[2].replace("form 0", "form 1"),
            "it holds several transforms that are not a composite",
        ),
        ("x.nii", "nothing", "it is not a NIfTI file"),
    ],
)
def test_broken_files_are_one_sentence(grid, name, content, sentence):
    Path(name).write_text(content)
    with pytest.raises(ValueError, match=f"^`{name}` cannot be used: {sentence}") as caught:
        io.read_transform(name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("transform", "sentence"),
    [
        (sitk.BSplineTransform(3, 3), "its BSplineTransform is neither linear nor a displacement"),
        (sitk.AffineTransform(2), "its transform must have 3 dimensions, got 2"),
    ],
)
def test_other_transforms_of_simpleitk_are_one_sentence(grid, transform, sentence):
    sitk.WriteTransform(transform, "x.tfm")
    with pytest.raises(ValueError, match=f"^`x.tfm` cannot be used: {sentence}"):
        io.read_transform("x.tfm")


def test_images_that_are_no_fields_are_one_sentence(grid, rng):
    sitk.WriteImage(itk_image(smooth_values(grid), grid), "x.mha")
    with pytest.raises(ValueError, match="3 floating-point components, got 1 of float64"):
        io.read_transform("x.mha")
    image = nibabel.Nifti1Image(rng.normal(size=(4, 5, 6, 1, 3)), np.eye(4))
    nibabel.save(image, "x.nii")
    with pytest.raises(ValueError, match="the intent code 1006 or 1007, got 0"):
        io.read_transform("x.nii")
    field_files.write(random_field(grid, rng), grid, "x.nrrd", is_forward=True)
    with pytest.raises(ValueError, match=r"its field moves points \(displacement field type"):
        io.read_transform("x.nrrd")
    Path("x.png").write_text("picture")
    with pytest.raises(ValueError, match=r"^cannot read a transform from `x\.png`: .*\.h5, "):
        io.read_transform("x.png")


def test_what_cannot_be_written_is_one_sentence(grid, deformation):
    cases = [
        ((deformation, "x.h5"), "`grid` must be given to write this Deformation"),
        ((Affine(MATRIX), "x.nrrd"), "`grid` must be given to write this Affine"),
        ((deformation, "x.mat", grid), r"cannot write a displacement field to `x\.mat`"),
        ((deformation, "x.nii", grid, "fsl"), "`convention` must be itk or ants, got `fsl`"),
    ]
    for arguments, sentence in cases:
        with pytest.raises(ValueError, match=f"^{sentence}"):
            io.write_transform(*arguments)
    with pytest.raises(TypeError, match="^`transform` must be a Deformation, Affine, Field or Ch"):
        io.write_transform(np.eye(4), "x.h5")
    with pytest.raises(TypeError, match="^`grid` must be a Grid"):
        io.write_transform(deformation, "x.h5", (4, 4, 4))
    assert not [*Path().glob("x*")]


def test_without_simpleitk_it_is_named(grid, between, monkeypatch):
    """Matrices in text are read all the same."""
    euler, affine = linear_transforms()[:2]
    composite = sitk.CompositeTransform([affine, affine])
    for transform, name in ((affine, "x.tfm"), (composite, "y.txt"), (euler, "z.tfm")):
        sitk.WriteTransform(transform, name)
    monkeypatch.setitem(sys.modules, "SimpleITK", None)
    for transform, name in ((affine, "x.tfm"), (composite, "y.txt")):
        found = io.read_transform(name).backward(between)
        np.testing.assert_allclose(found, moved_by(transform, between), atol=1e-12)
    with pytest.raises(ValueError, match=r"^`z\.tfm` holds Euler3DTransform, which needs the pac"):
        io.read_transform("z.tfm")
    with pytest.raises(ValueError, match=r"^`x\.tfm` needs the package SimpleITK: pip inst"):
        io.write_transform(Affine(MATRIX), "x.tfm")


@pytest.mark.parametrize("name", ["x.tfm", "x.mat"])
def test_the_old_file_stays_when_the_disk_is_full(grid, monkeypatch, name):
    """ITK does not notice it."""
    usual = sitk.WriteTransform

    def write(transform, path):
        usual(transform, path)
        content = Path(path).read_bytes()
        Path(path).write_bytes(content[:60] if name == "x.tfm" else b"")

    monkeypatch.setattr(sitk, "WriteTransform", write)
    Path(name).write_text("old")
    with pytest.raises(OSError, match=rf"^`{name}` could not be written: No space left"):
        io.write_transform(Affine(MATRIX), name)
    assert Path(name).read_text() == "old"
