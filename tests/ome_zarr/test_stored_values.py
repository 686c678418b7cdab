"""What OME-Zarr holds beside one image: labels, other groups, levels, axes, orientation (RFC 4)."""

import itertools
import json
from pathlib import Path

import ngff_zarr
import nibabel
import numpy as np
import pytest
import SimpleITK as sitk
import zarr
from zarr_images import HANDLES, ORIGIN, SHAPE, SPACING, halves, values, write

from vtk_mls import Deformation, Grid, Sampling, io
from vtk_mls.blocks import image_blocks as blocks
from vtk_mls.blocks import image_job as job
from vtk_mls.commands import view
from vtk_mls.commands.cli import main
from vtk_mls.dask import resample
from vtk_mls.files.ome_zarr import open_image
from vtk_mls.vtk.arrays import ImageGeometry

pytestmark = pytest.mark.usefixtures("folder")
GRID = Grid(SHAPE[::-1], ORIGIN[::-1], SPACING[::-1])
D = Deformation(HANDLES[:, :3], HANDLES[:, 3:], device="reference")
SETTINGS = {"interpolation": "linear", "background": 0.0, "void_values": "background"}
REST = Deformation(HANDLES[:, :3], HANDLES[:, :3], device="reference")


def level(path, number=0):
    return open_image(path).levels[number].array[...]


def nearest(stored):
    (moved,) = D.resample([stored], Sampling(GRID, interpolation="nearest"))
    return moved


def change(path, edit):
    """Edit the metadata of an image of version 0.5."""
    file = Path(path, "zarr.json")
    content = json.loads(file.read_text())
    edit(content["attributes"]["ome"])
    file.write_text(json.dumps(content))


@pytest.mark.parametrize("version", ["0.4", "0.5"])
@pytest.mark.parametrize("is_listed", [True, False])
@pytest.mark.parametrize("is_declared", [True, False])
def test_no_label_image_is_blended(version, is_listed, is_declared, rng):
    file = write("in.ome.zarr", halves(values(rng), 2), version)
    if is_listed:
        listed = {"labels": ["cells"]}
        listed = listed if version == "0.4" else {"ome": {"version": version, **listed}}
        file.create_group("labels").attrs.update(listed)
    labels = 10**9 * rng.integers(0, 4, SHAPE, dtype="uint32")
    more = {"image-label": {}} if is_declared else {}
    write("in.ome.zarr/labels/cells", halves(labels, is_label=True), version, **more)
    command = ["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr"]
    assert main([*command, "--interpolation", "cubic"]) == 0
    for number, expected in enumerate(halves(nearest(labels), is_label=True)):
        np.testing.assert_array_equal(level("out.ome.zarr/labels/cells", number), expected)
    assert np.unique(level("out.ome.zarr")).size > 1000
    # by itself, it is still a label image, in other formats and in its own
    for target in ("cells.nrrd", "cells.ome.zarr", "again.ome.zarr"):
        source = "cells.ome.zarr" if target == "again.ome.zarr" else "in.ome.zarr/labels/cells"
        assert main(["deform", source, "handles.csv", target]) == 0
    assert io.read_dataset("cells.nrrd").GetFieldData().HasArray("LabelArrays")
    np.testing.assert_array_equal(level("cells.ome.zarr", 1), level("out.ome.zarr/labels/cells", 1))
    assert {*np.unique(level("again.ome.zarr", 1))} <= {0, 10**9, 2 * 10**9, 3 * 10**9}


@pytest.mark.parametrize(
    "options", [["--interpolation=nearest", "--background=0"], ["--label=OME-Zarr"]]
)
def test_arrays_opened_as_labels_are_not_blended(options, rng):
    labels = 100 * rng.integers(0, 4, SHAPE, dtype="uint16")
    file = write("in.ome.zarr", halves(labels, is_label=True))
    change("in.ome.zarr", lambda ome: ome["multiscales"][0].update(type="gaussian"))
    assert main(["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr", *options]) == 0
    for number, expected in enumerate(halves(nearest(labels), is_label=True)):
        np.testing.assert_array_equal(level("out.ome.zarr", number), expected)
    out = dict(zarr.open_group("out.ome.zarr", mode="r").attrs)["ome"]["multiscales"][0]
    assert (file.name, out["type"]) == ("/", "nearest")


def test_channels_of_labels_among_others(rng, refused):
    stored = np.stack([values(rng), 100 * rng.integers(0, 4, SHAPE)]).astype("uint16")
    channels = [{"label": "raw"}, {"label": "cells"}]
    write("in.ome.zarr", halves(stored), axes="czyx", omero={"channels": channels})
    command = ["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr", "--label"]
    assert main([*command, "cells"]) == 0
    (moved,) = D.resample([stored[0]], Sampling(GRID, background="auto"))
    means, labels = halves(moved), halves(nearest(stored[1]), is_label=True)
    for number, expected in enumerate(zip(means, labels)):
        np.testing.assert_array_equal(level("out.ome.zarr", number), expected)
    error = refused(*command, "cell")
    assert error == "`--label` must name channels of `in.ome.zarr`, which are raw, cells, got cell"


def test_other_groups_are_copied_and_other_images_are_named(rng, caplog):
    file = write("in.ome.zarr", [values(rng)])
    file.create_group("tables").attrs["tables"] = ["regions"]
    file.create_array("tables/regions/x", data=np.arange(5.0))
    file.create_group("OME")
    Path("in.ome.zarr/OME/METADATA.ome.xml").write_text("<OME/>")
    write("in.ome.zarr/other", [values(rng)])
    file.create_array("more", data=np.arange(3))
    job.deform("in.ome.zarr", "out.ome.zarr", D, SETTINGS)
    out = zarr.open_group("out.ome.zarr", mode="r")
    assert out["tables"].attrs["tables"] == ["regions"]
    np.testing.assert_array_equal(out["tables/regions/x"], np.arange(5))
    assert Path("out.ome.zarr/OME/METADATA.ome.xml").read_text() == "<OME/>"
    assert "more, other belong to no deformed image and are not copied" in caplog.text
    assert {*out} == {"scale0", "tables", "OME"}


@pytest.mark.parametrize("factors", [(1, 2, 4), (1, 2, 3, 4), (1, 3, 9), (1, 2.5, 5)])
@pytest.mark.parametrize("is_label", [False, True])
def test_levels_lie_where_their_metadata_say(factors, is_label, rng):
    """Levels made by sampling are sampled: at rest, the output is the input."""
    places = [[np.arange(0, n, f) for n in SHAPE] for f in factors]
    ramp = np.add.outer(np.add.outer(np.arange(12.0) * 40, np.arange(20) * 20), np.arange(26) * 2)
    stored = [np.add.outer(np.add.outer(z * 40, y * 20), x * 2) for z, y, x in places]
    stored = [array.astype("float32") for array in stored]
    assert np.array_equal(stored[0], ramp)
    write("in.ome.zarr", stored, **({"image-label": {}} if is_label else {}))

    def place(ome):
        for dataset, factor in zip(ome["multiscales"][0]["datasets"], factors):
            scale = [n * factor for n in SPACING]
            dataset["coordinateTransformations"] = [
                {"type": "scale", "scale": scale},
                {"type": "translation", "translation": ORIGIN},
            ]
        ome["multiscales"][0]["type"] = "mean"

    change("in.ome.zarr", place)
    job.deform("in.ome.zarr", "out.ome.zarr", REST, SETTINGS)
    for number, (factor, expected) in enumerate(zip(factors, stored)):
        tolerance = 31 if is_label and factor % 1 else 1e-3
        np.testing.assert_allclose(level("out.ome.zarr", number), expected, atol=tolerance)
    out = dict(zarr.open_group("out.ome.zarr", mode="r").attrs)["ome"]["multiscales"][0]
    assert out["type"] == "nearest"


@pytest.mark.parametrize("factor", [1.5, 2.0, 2.5, 3.0])
def test_windows_are_means_of_what_they_cover(factor, rng):
    fine = rng.random(30)
    count = int(30 / factor)
    centers = factor * np.arange(count) + (factor - 1) / 2
    parts = np.repeat(fine, 10).reshape(-1)[: int(count * factor * 10)].reshape(count, -1)
    found = blocks.coarsened(fine, [centers], [factor])
    np.testing.assert_allclose(found, parts.mean(axis=1), rtol=1e-12)


UNITS = {
    "nm": ({"z": "micrometer", "y": "nanometer", "x": "nanometer"}, (4000, 2, 3), ""),
    "inch": ({"z": "inch", "y": "centimeter", "x": "millimeter"}, (101.6, 20, 3), ""),
    "none": ({"z": None, "y": "nanometer", "x": None}, (4, 2, 3), "z, x has no unit; nanometer is"),
    "other": ({"z": "pixel", "y": "pixel", "x": "pixel"}, (4, 2, 3), ""),
}


@pytest.mark.parametrize("case", UNITS)
@pytest.mark.parametrize("are_capitals", [False, True])
def test_units_that_differ_and_names_in_capitals(case, are_capitals, rng, caplog):
    units, spacing, said = UNITS[case]
    stated = {name: {"unit": unit} for name, unit in units.items()}
    write("in.ome.zarr", halves(values(rng), 2), stated=stated)

    def raise_names(ome):
        for axis in ome["multiscales"][0]["axes"]:
            axis["name"] = axis["name"].upper() if are_capitals else axis["name"]

    change("in.ome.zarr", raise_names)
    image = io.read_dataset("in.ome.zarr")
    np.testing.assert_allclose(image.GetSpacing(), spacing[::-1])
    assert said.upper() in caplog.text.upper()
    job.deform("in.ome.zarr", "out.ome.zarr", D, SETTINGS)
    job.write_field("in.ome.zarr", "field.ome.zarr", D)
    for path in ("out.ome.zarr", "field.ome.zarr"):
        np.testing.assert_allclose(open_image(path).finest.grid.spacing, spacing[::-1])


def test_masks_of_bool_are_labels(rng):
    mask = values(rng) > 15000
    write("in.ome.zarr", halves(mask, is_label=True))
    assert main(["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr"]) == 0
    for number, expected in enumerate(halves(nearest(mask.astype("uint8")), is_label=True)):
        found = level("out.ome.zarr", number)
        assert found.dtype == bool
        np.testing.assert_array_equal(found, expected)
    image = io.read_dataset("in.ome.zarr")
    assert image.GetFieldData().HasArray("LabelArrays")


@pytest.mark.parametrize("axes", ["yx", "cyx", "tyx", "tcyx"])
def test_the_field_of_a_flat_image(axes, monkeypatch):
    monkeypatch.setattr(blocks, "MAX_VALUES", 3 * 8 * 10)
    write("in.ome.zarr", [np.zeros((*[2] * len(axes[:-2]), *SHAPE[1:]), "u1")], axes=axes)
    assert main(["field", "in.ome.zarr", "handles.csv", "field.ome.zarr"]) == 0
    grid = Grid((*SHAPE[:0:-1], 1), (*ORIGIN[:0:-1], 0), (*SPACING[:0:-1], 1))
    field = D.displacement_field(grid).displacement[0]
    np.testing.assert_array_equal(np.moveaxis(level("field.ome.zarr"), 0, -1), field)


# Orientation through all doors, against nibabel and SimpleITK

SIDES = {"R": "left", "L": "right", "A": "posterior", "P": "anterior"}
SIDES |= {"S": "inferior", "I": "superior"}
NAMES = {"R": "right", "L": "left", "A": "anterior", "P": "posterior"}
NAMES |= {"S": "superior", "I": "inferior"}
CODES = [  # 48: where x, y and z of a file grow to
    "".join(code)
    for axes in itertools.permutations(("RL", "AP", "SI"))
    for code in itertools.product(*axes)
]
ON_SEVEN = SETTINGS | {"background": 7.0}
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
    job.deform("in.ome.zarr", "out.ome.zarr", d, ON_SEVEN)
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
    job.deform(tmp_path / "in.ome.zarr", tmp_path / "out.ome.zarr", d, ON_SEVEN)
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
