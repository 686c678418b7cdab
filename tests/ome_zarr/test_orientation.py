"""The orientation of OME-Zarr's axes (RFC 4) through all doors, against nibabel and SimpleITK."""

import itertools

import ngff_zarr
import nibabel
import numpy as np
import pytest
import SimpleITK as sitk
from zarr_images import HANDLES, ORIGIN, SHAPE, SPACING, halves, values, write

from vtk_mls import Deformation, Grid, Sampling, io
from vtk_mls.blocks import image_job as job
from vtk_mls.commands import view
from vtk_mls.commands.cli import main
from vtk_mls.dask import resample
from vtk_mls.files.ome_zarr import open_image
from vtk_mls.vtk.arrays import ImageGeometry

SIDES = {"R": "left", "L": "right", "A": "posterior", "P": "anterior"}
SIDES |= {"S": "inferior", "I": "superior"}
NAMES = {"R": "right", "L": "left", "A": "anterior", "P": "posterior"}
NAMES |= {"S": "superior", "I": "inferior"}
CODES = [  # 48: where x, y and z of a file grow to
    "".join(code)
    for axes in itertools.permutations(("RL", "AP", "SI"))
    for code in itertools.product(*axes)
]
SETTINGS = {"interpolation": "linear", "background": 7.0, "void_values": "background"}
LPS = np.array([-1.0, -1, 1])


def words(code, is_string=False):
    """Entries of the axes x, y, z for a code such as RAS."""
    stated = [f"{SIDES[letter]}-to-{NAMES[letter]}" for letter in code]
    forms = [text if is_string else {"type": "anatomical", "value": text} for text in stated]
    return {name: {"orientation": form} for name, form in zip("xyz", forms)}


def grid_of(code, spacing=SPACING, origin=ORIGIN, shape=SHAPE):
    """The grid of a file in LPS, by nibabel."""
    columns = np.zeros((3, 3))
    for axis, (row, sign) in enumerate(nibabel.orientations.axcodes2ornt(code)):
        columns[int(row), axis] = sign
    columns *= LPS[:, None]
    return Grid(shape[::-1], columns @ origin[::-1], spacing[::-1], columns)


def deformation(grid):
    """A map that moves the same voxels of each grid, though not to the same side."""
    rest, moved = (HANDLES[:, n : n + 3] for n in (0, 3))
    middle = np.array([42.0, 18, 29])
    center = grid.at([(np.array(grid.dimensions) - 1) / 2])
    return Deformation(rest - middle + center, moved - middle + center, device="reference")


def same_places(found, expected):
    np.testing.assert_allclose(found.corners(), expected.corners(), atol=1e-4)
    assert found.dimensions == expected.dimensions


@pytest.mark.parametrize("code", CODES)
def test_each_orientation_through_each_door(code, rng, folder):
    number, stored = CODES.index(code), values(rng)[:6, :10, :14]
    grid = grid_of(code, shape=stored.shape)
    stated, version = words(code, number % 2), ("0.4", "0.5")[number // 2 % 2]
    write("in.ome.zarr", halves(stored, 2), version, (3, 5, 7), stated=stated)
    assert open_image("in.ome.zarr").levels[1].grid.index_of(grid.origin[None]) == pytest.approx(
        np.full((1, 3), -0.25)
    )
    image = io.read_dataset("in.ome.zarr")
    same_places(ImageGeometry.of_image(image).grid, grid)
    direction = ImageGeometry.of_image(image).grid.direction.ravel()
    oriented = sitk.DICOMOrientImageFilter.GetOrientationFromDirectionCosines(direction.tolist())
    assert oriented == code
    for ending in (".vti", ".nii.gz", ".nrrd", ".mha"):
        io.write_dataset(image, f"out{ending}")
        again = io.read_dataset(f"out{ending}")
        unit = 1e-3 if ending == ".nii.gz" else 1  # NIfTI in micrometers is read in millimeters
        same_places(
            ImageGeometry.of_image(again).grid,
            Grid(grid.dimensions, unit * grid.origin, unit * grid.spacing, grid.direction),
        )
    file = nibabel.load("out.nii.gz")
    assert "".join(nibabel.aff2axcodes(file.affine)) == code
    np.testing.assert_array_equal(np.asanyarray(file.dataobj).T, stored)
    assert file.header.get_xyzt_units()[0] == "micron"
    for ending in (".nrrd", ".mha"):
        peer = sitk.ReadImage(f"out{ending}")
        np.testing.assert_array_equal(sitk.GetArrayFromImage(peer), stored)
        np.testing.assert_allclose(peer.GetOrigin(), grid.origin, atol=1e-9)
    d = deformation(grid)
    (expected,) = d.resample([stored], Sampling(grid, background=7))
    assert not np.array_equal(expected, stored)
    job.deform("in.ome.zarr", "out.ome.zarr", d, SETTINGS)
    out = open_image("out.ome.zarr")
    np.testing.assert_array_equal(out.finest.array[...], expected)
    same_places(out.finest.grid, grid)
    axes = ngff_zarr.from_ngff_zarr("out.ome.zarr").images[0].axes_orientations
    assert number % 2 or axes["x"].value == stated["x"]["orientation"]["value"]
    lazy = resample(out.finest.array, d, Sampling(out.finest.grid), chunks=13)
    np.testing.assert_array_equal(lazy, d.resample([expected], grid)[0])
    job.write_field("in.ome.zarr", "field.ome.zarr", d)
    field = open_image("field.ome.zarr")
    same_places(field.finest.grid, grid)
    vectors = np.moveaxis(field.finest.array[...], 0, -1)
    np.testing.assert_array_equal(vectors, d.displacement_field(grid).displacement)
    assert field.channel_names == ["to the left", "to posterior", "to superior"]


@pytest.mark.parametrize("codes", [("RA", "RAS"), ("LP", "LPS"), ("SA", "SAL"), ("RS", "RSP")])
def test_flat_images_have_the_third_direction(codes, rng, tmp_path):
    flat, code = codes
    write(tmp_path / "in.ome.zarr", [values(rng)[0]], axes="yx", stated=words(code))
    expected = grid_of(code, (1, *SPACING[1:]), (0, *ORIGIN[1:]), (1, *SHAPE[1:]))
    same_places(open_image(tmp_path / "in.ome.zarr").finest.grid, expected)
    assert flat == code[:2]


def test_label_images_take_what_their_image_states(rng, tmp_path):
    """Writers of label images state neither orientation nor unit."""
    stored = values(rng)
    write(tmp_path / "in.ome.zarr", [stored], stated=words("RAI"))
    labels = (stored // 20000).astype("uint8")
    cells, grid = tmp_path / "in.ome.zarr/labels/cells", grid_of("RAI")
    write(cells, [labels], stated={name: {"unit": "nanometer"} for name in "zyx"})
    small = grid_of("RAI", np.array(SPACING) / 1000, np.array(ORIGIN) / 1000)
    same_places(open_image(cells).finest.grid, small)
    write(cells, halves(labels, is_label=True), stated={key: {"unit": None} for key in "zyx"})
    same_places(open_image(cells).finest.grid, grid)
    d = deformation(grid)
    job.deform(tmp_path / "in.ome.zarr", tmp_path / "out.ome.zarr", d, SETTINGS)
    (expected,) = d.resample([labels], Sampling(grid, interpolation="nearest", background=7))
    for number, level in enumerate(halves(expected, is_label=True)):
        found = open_image(tmp_path / "out.ome.zarr/labels/cells").levels[number].array[...]
        np.testing.assert_array_equal(found, level)
    shown = view._read_dataset(tmp_path / "in.ome.zarr")
    same_places(ImageGeometry.of_image(shown).grid, grid)


@pytest.mark.parametrize(
    "stated",
    [
        {"x": "left-to-right"},
        {"x": "left-to-right", "y": "right-to-left", "z": "inferior-to-superior"},
        {"x": "left-to-right", "y": "ventral-to-dorsal", "z": "caudal-to-rostral"},
    ],
)
def test_data_without_a_frame_are_reported(stated, rng, folder, caplog):
    stated = {name: {"orientation": text} for name, text in stated.items()}
    write("in.ome.zarr", [values(rng)], stated=stated)
    for target in ("out.ome.zarr", "out.vti"):
        assert main(["deform", "in.ome.zarr", "handles.csv", target]) == 0
        said = caplog.text
        caplog.clear()
        assert "`in.ome.zarr`: the orientation (x left-to-right, y" in said
        assert said.count("does not give LPS; positions are used as LPS") == 1
    as_lps = Grid(SHAPE[::-1], ORIGIN[::-1], SPACING[::-1])
    same_places(open_image("in.ome.zarr").finest.grid, as_lps)


def test_other_orientations_are_none_of_a_patient(rng, tmp_path):
    stated = {"x": {"orientation": {"type": "engineering", "value": "upstream-to-downstream"}}}
    write(tmp_path / "in.ome.zarr", [values(rng)], stated=stated)
    image = open_image(tmp_path / "in.ome.zarr")
    assert (image.guess, image.finest.grid.direction.tolist()) == ("", np.eye(3).tolist())
