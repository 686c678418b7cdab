"""Other programs, given only the file of a field, deform as we do."""

import re
from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk
import slicer_peer
from file_fixtures import DIRECTIONS, IMAGES, handles_on, transform_by_itk
from pipelines import values_of
from vtk_fixtures import DEFORMED, REST, add_array, add_scalars, make_image
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import Deformation, Grid, io
from vtk_mls.commands.cli import main
from vtk_mls.files import field_files
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import output_of


def write_handles(rest, deformed):
    np.savetxt("handles.csv", np.hstack([rest, deformed]), "%.17g", ",")


@pytest.fixture(params=DIRECTIONS)
def scene(request, tmp_path, monkeypatch):
    """A folder with in.mha, oblique, and handles.csv, as the current one; the grid, p and q."""
    image = make_image((18, 17, 16), direction=DIRECTIONS[request.param], origin=(20, -30, 40))
    grid = ImageGeometry.of_image(image).grid
    rest, deformed = handles_on(grid)
    x, y, z = (grid.points() - rest.mean(axis=0)).T
    add_scalars(image, "values", 9 * np.sin(x / 3) + 2 * y + z * z / 4)
    monkeypatch.chdir(tmp_path)
    io.write_dataset(image, "in.mha")
    write_handles(rest, deformed)
    return grid, rest, deformed


def run(command, path, *options, source="in.mha"):
    """Call the command with a file and handles.csv."""
    arguments = [command, source, "handles.csv", path, *options]
    assert main(list(map(str, arguments))) == 0


def values_by_itk(path):
    return sitk.GetArrayFromImage(sitk.ReadImage(str(path)))


@pytest.mark.parametrize("suffix", [*IMAGES, ".h5", ".tfm"])
@pytest.mark.parametrize(
    ("options", "said"), [((), "backward displacements"), (("--inverse",), "forward displacements")]
)
def test_simpleitk_moves_landmarks_as_we_do(scene, suffix, options, said, capsys):
    grid, rest, deformed = scene
    run("field", f"field{suffix}", "--kind=affine", *options)
    printed = capsys.readouterr()
    assert f"field{suffix}: 18 x 17 x 16 {said}, affine" in printed.out
    assert printed.err == ""
    transform = transform_by_itk(f"field{suffix}")
    value = Deformation(rest, deformed, "affine", device="reference")
    on_points = grid.at([[5, 6, 7], [9, 8, 8], [12, 10, 4]])
    between = grid.at([[5.5, 6.2, 7.1], [9.3, 8.9, 8.5], [12.1, 9.4, 4.5]])
    for landmarks, tolerance in ((on_points, 1e-4), (between, 0.02)):  # bent within a voxel
        moved = [transform.TransformPoint(point) for point in landmarks.tolist()]
        expected = (value.forward if options else value.backward)(landmarks)
        np.testing.assert_allclose(moved, expected, atol=tolerance)
        assert np.abs(expected - landmarks).max() > 0.5


@slicer_peer.needs_slicer
def test_slicer_reads_transforms(scene):
    grid, rest, deformed = scene
    paths = [f"field-{suffix[1:]}{suffix}" for suffix in IMAGES]
    for path in paths:
        run("field", path)
    points = grid.at([[5, 6, 7], [9, 8, 8], [12, 10, 4]])
    value = Deformation(rest, deformed, device="reference")
    back, forth = value.backward(points), value.forward(points)
    for resampling, moving in slicer_peer.moved(points, paths):
        np.testing.assert_allclose(resampling, back, atol=1e-4)
        np.testing.assert_allclose(moving, forth, atol=0.02)  # between points
    assert np.abs(back - points).max() > 0.5
    assert np.abs(forth - points).max() > 0.5


def test_for_vtk_the_field_is_written_with_its_arrays(scene, capsys):
    grid, rest, _ = scene
    cut = ",".join(map(str, [*grid.corners().mean(axis=0), 1, 0, 0, 0, 0, 1]))
    write_handles(rest, rest + np.sign(rest - rest.mean(axis=0)))
    run("field", "field.vti", f"--cut-half-plane={cut}")
    assert capsys.readouterr().err == ""
    image = io.read_dataset("field.vti")
    assert values_of(image, "BackwardDisplacement").shape == (16, 17, 18, 3)
    void = int(values_of(image, "Void").sum())
    assert void > 0
    run("field", "field.nrrd", f"--cut-half-plane={cut}")
    printed = capsys.readouterr().err
    assert printed.startswith(f"vtk-mls: `field.nrrd`: {void} of 4896 points are void, which this")
    assert printed.count("\n") == 1
    np.testing.assert_array_equal(
        values_by_itk("field.nrrd"), values_of(image, "BackwardDisplacement")
    )


def test_what_has_no_forward_image_is_counted(scene, capsys):
    grid, rest, _ = scene
    center = grid.corners().mean(axis=0)
    write_handles(rest, np.where(rest[:, :1] < center[0], rest + [3, 0, 0], rest - [3, 0, 0]))
    cut = f"--cut-plane={','.join(map(str, center))},1,0,0"
    run("field", "field.mha", "--inverse", cut, "--cut-frame=deformed")
    found = capsys.readouterr().err
    assert found.startswith("vtk-mls: `field.mha`: ")
    assert " of 4896 points have no forward image" in found
    assert np.isfinite(values_by_itk("field.mha")).all()
    assert int(found.split("`: ")[1].split()[0]) > 1000


@pytest.mark.parametrize("suffix", [".mha", ".nii.gz", ".nrrd"])
@pytest.mark.parametrize("options", [(), ("--inverse",)])
def test_determinants(scene, suffix, options, capsys):
    grid, rest, deformed = scene
    run("field", f"determinant{suffix}", "--jacobian", *options)
    assert "determinants, rigid; 0 of them not above 0" in capsys.readouterr().out
    image = sitk.ReadImage(f"determinant{suffix}")
    np.testing.assert_allclose(image.GetOrigin(), grid.origin, rtol=1e-6)
    np.testing.assert_allclose(image.GetDirection(), grid.direction.ravel(), atol=1e-6)
    assert image.GetNumberOfComponentsPerPixel() == 1
    values = sitk.GetArrayFromImage(image).ravel()
    value, points = Deformation(rest, deformed, device="reference"), grid.points()
    if options:
        expected = 1 / np.linalg.det(value.jacobian(value.forward(points)))
    else:
        expected = np.linalg.det(value.jacobian(points))
    np.testing.assert_allclose(values, expected, rtol=1e-3)
    assert np.ptp(values) > 0.05


def test_a_mesh_gives_its_bounds(scene):
    sphere = output_of(vtkSphereSource(), Center=(20, -30, 40))
    io.write_dataset(sphere, "in.vtp")
    arguments = ["field", "in.vtp", "handles.csv", "field.nrrd"]
    assert main([*arguments, "--dimensions", "5,6,7"]) == 0
    image = sitk.ReadImage("field.nrrd")
    assert image.GetSize() == (5, 6, 7)
    np.testing.assert_allclose(image.GetOrigin(), sphere.GetBounds()[::2])
    assert main(arguments) == 0
    assert sitk.ReadImage("field.nrrd").GetSize() == (32, 32, 32)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({2: "out.png"}, "cannot write a displacement field to `out.png`: its name must end in"),
        ({3: "--dimensions=4,4,4"}, "`--dimensions` is for meshes: `in.mha` is an image"),
        ({0: "in.vtp", 3: "--dimensions=4,4"}, "`--dimensions` must be 3 numbers with commas"),
        ({0: "in.vtp", 3: "--dimensions=4,0,4"}, "`--dimensions` must be three positive integers"),
    ],
)
def test_errors_are_one_sentence(scene, refused, change, sentence):
    io.write_dataset(output_of(vtkSphereSource()), "in.vtp")
    arguments = ["in.mha", "handles.csv", "out.nrrd", "--kind=rigid"]
    for position, argument in change.items():
        arguments[position] = argument
    assert refused("field", *arguments).startswith(sentence)
    assert not list(Path().glob("out*"))


def test_a_field_without_vtk_is_written(tmp_path):
    """As somebody does who has no VTK."""
    grid = Grid((5, 4, 3), (1, 2, 3), (2, 1, 0.5))
    field = Deformation(REST, DEFORMED, device="reference").displacement_field(grid)
    field_files.write(field.displacement, field.grid, str(tmp_path / "x.nrrd"))
    np.testing.assert_array_equal(values_by_itk(tmp_path / "x.nrrd"), field.displacement)
    with pytest.raises(ValueError, match=r"to `x\.png`: its name must end in one of \.nii\.gz, "):
        field_files.write(field.displacement, field.grid, "x.png")


@pytest.mark.parametrize("suffix", IMAGES)
@pytest.mark.parametrize("is_folded", [False, True])
def test_the_certificate_agrees_with_itk(scene, suffix, is_folded, capsys):
    """ITK's determinants are central differences, less strict than tetrahedra."""
    grid, rest, deformed = scene
    if is_folded:
        write_handles(rest, rest + 6 * (deformed - rest))
    run("field", f"field{suffix}")
    field = sitk.ReadImage(f"field{suffix}", sitk.sitkVectorFloat64)
    determinants = sitk.GetArrayFromImage(sitk.DisplacementFieldJacobianDeterminant(field))
    printed = capsys.readouterr().out
    count = grid.cells.size
    if is_folded:
        found = re.search(rf"interpolated linearly, folds in (\d+) of {count} voxels", printed)
        assert int(found[1]) > 0
        assert (determinants <= 0).any()
    else:
        sentence = f"interpolated linearly, proven to keep orientation in all {count} voxels"
        assert sentence in printed
        assert (determinants[2:-2, 2:-2, 2:-2] > 0).all()


def test_a_finer_field_does_not_fold(tmp_path, monkeypatch, capsys):
    """Handles that turn within few voxels: the map does not fold, its linear field does.

    ITK's determinants are right on grids along the axes of the world.
    """
    monkeypatch.chdir(tmp_path)
    image = make_image((18, 17, 16), origin=(20, -30, 40))
    add_array(image.GetPointData(), "values", np.zeros(image.GetNumberOfPoints()))
    io.write_dataset(image, "in.mha")
    low, high = np.reshape(image.GetBounds(), (3, 2)).T
    rng = np.random.default_rng(5)
    rest = np.r_[0.5 + 0.02 * rng.normal(size=(3, 3)), np.eye(3), [(0, 0, 0), (1, 1, 1)]]
    deformed = rest.copy()
    deformed[:3] = 0.5 + (rest[:3] - 0.5) @ [(0, -1, 0), (1, 0, 0), (0, 0, 1)]
    write_handles(*(low + (high - low) * places for places in (rest, deformed)))
    run("field", "coarse.mha", "--steps", "auto")
    coarse = capsys.readouterr().out
    assert "folds in" in coarse
    run("field", "fine.mha", "--steps", "auto", "--spacing-factor", "auto")
    assert "proven to keep orientation" in capsys.readouterr().out
    field = sitk.ReadImage("fine.mha", sitk.sitkVectorFloat64)
    spacing = ", ".join(f"{length:.6g}" for length in field.GetSpacing())
    assert f"a field with the spacing {spacing} does not fold" in coarse
    determinants = sitk.GetArrayFromImage(sitk.DisplacementFieldJacobianDeterminant(field))
    assert (determinants[2:-2, 2:-2, 2:-2] > 0).all()
