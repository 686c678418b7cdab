"""Data of many types are drawn correctly, with handles on what is visible, or refused."""

from __future__ import annotations

import numpy as np
import pytest
from command_fixtures import run
from hands import MIDDLE, SIZE, Hands, ball_image, ball_mesh, pixels_in
from pipelines import ball
from vtk_fixtures import TURNED, add_array, add_scalars, polydata_of
from vtkmodules.vtkCommonCore import (
    VTK_BIT,
    VTK_INT,
    VTK_LONG_LONG,
    VTK_SHORT,
    VTK_SIGNED_CHAR,
    VTK_UNSIGNED_SHORT,
)
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersSources import vtkPlaneSource, vtkPointSource

from vtk_mls import io
from vtk_mls.editor import State
from vtk_mls.editor.label_picking import are_regions
from vtk_mls.files import metadata
from vtk_mls.rendering import transfer_functions
from vtk_mls.rendering.transfer_functions import scalar_image
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured, output_of


def image_with(values, dimensions):
    image = configured(vtkImageData(), Dimensions=dimensions)
    if values is not None:
        arrays.add(image.GetPointData(), "values", values)
        image.GetPointData().SetActiveScalars("values")
    return image


UNUSUAL = {
    "two voxels": lambda: image_with(np.array([0.0, 1.0]), (2, 1, 1)),
    "one voxel": lambda: image_with(np.array([1.0]), (1, 1, 1)),
    "a slice": lambda: image_with(np.arange(20.0), (5, 4, 1)),
    "eight voxels": lambda: image_with(np.arange(8.0), (2, 2, 2)),
    "all the same": lambda: image_with(np.zeros(27), (3, 3, 3)),
    "not finite": lambda: image_with(np.r_[np.nan, np.inf, np.arange(25.0)], (3, 3, 3)),
    "colors": lambda: image_with(np.arange(81).reshape(27, 3).astype(np.uint8), (3, 3, 3)),
    "points": lambda: polydata_of([(i, i * i, 1) for i in range(5)]),
}


_SLOW = "not finite", "colors"  # each builds a shader


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.matrix] * (name in _SLOW)) for name in UNUSUAL]
)
def test_unusual_data_are_edited(name):
    hands = Hands(UNUSUAL[name]())
    front = int(hands.pixels(hands.state.deformed)[:, 2].argmin())
    hands.drag(hands.pixel_of(front), (20, 10))
    for key in "cavz":
        hands.press(key)
    hands.drag((120, 120), (10, 10), "Ctrl")
    assert len(hands.state) > 0


def test_an_image_without_values_is_refused():
    with pytest.raises(ValueError, match="no values at its points"):
        Hands(image_with(None, (3, 3, 3)))
    with pytest.raises(ValueError, match="no finite values to show"):
        Hands(image_with(np.full(27, np.nan), (3, 3, 3)))


_HALVES = np.repeat([0, 3], 100)  # of a flat image, 20 x 10: the upper half, and the lower


@pytest.mark.parametrize(
    ("values", "upper", "lower"),
    [
        pytest.param(np.repeat(np.linspace(0, 900, 10), 20), (25, 25, 25), (230, 230, 230)),
        pytest.param(_HALVES, (0, 0, 0), 255 * transfer_functions._HUES[3]),
        pytest.param(
            np.uint8([(200, 10, 50)] * 100 + [(5, 90, 240)] * 100), (200, 10, 50), (5, 90, 240)
        ),
    ],
    ids=["gray", "labels", "colors"],
)
def test_a_flat_image_is_seen_from_the_front(values, upper, lower):
    """A handle that is dragged stays in the plane, and the image follows it."""
    hands = Hands(image_with(values, (20, 10, 1)), State([(9.5, 4.5, 0)], [(9.5, 4.5, 0)]))
    assert hands.editor.slices.pane == "axial"
    pane = hands.editor.slices.pane_at((120, 120))
    places = [(4, 0.5, 0), (4, 8.5, 0)]

    def shown(offset=0):
        (x, y), (u, v) = np.rint(pixels_in(pane, np.add(places, offset))).astype(int)
        return hands.picture()[[y, v], [x, u]]

    np.testing.assert_allclose(shown(), [upper, lower], atol=30)
    start = pixels_in(pane, (9.5, 4.5, 0))[0]
    hands.drag(start, (30, 12))
    moved = hands.state.deformed[0] - (9.5, 4.5, 0)
    assert moved[2] == 0
    assert np.abs(moved[:2]).min() > 0.5
    np.testing.assert_allclose(shown(moved), [upper, lower], atol=30)


def test_an_image_with_one_value_is_visible():
    hands = Hands(image_with(np.full(1000, -5.0), (10, 10, 10)))
    assert np.abs(hands.picture()[120, 120] - hands.picture()[5, 5]).max() > 50


def test_gray_values_are_no_labels(rng):
    shell = np.clip(200 * (8.5 - np.linalg.norm(np.indices((24,) * 3) - 11.5, axis=0)), 0, 200)
    noise, blocks = rng.integers(0, 9, (20, 20, 20)), np.repeat(np.arange(8), 64).reshape(8, 8, 8)
    assert not are_regions(shell.astype(np.uint8))
    assert not are_regions(noise)
    assert not are_regions(np.zeros((9, 9, 9), int))
    assert are_regions(blocks)


def test_an_oblique_image_is_drawn_and_picked_in_place():
    geometry = ImageGeometry(
        (3, SIZE + 2) * 3, (5.0, -3.0, 40.0), (1.0, 2.0, 0.5), tuple(TURNED.ravel())
    )
    hands = Hands(ball_image(geometry))
    grid = geometry.grid
    center = grid.at([[MIDDLE] * 3])[0]
    np.testing.assert_allclose(hands.state.rest.mean(axis=0), center, atol=1)
    hit = hands.hit((120, 120))
    radius = np.linalg.norm(grid.index_of([hit])[0] - MIDDLE)
    assert radius == pytest.approx(SIZE / 3, abs=1.5)
    edge = hands.pixels(hit[None])[0, :2]
    np.testing.assert_allclose(edge, (120, 120), atol=1e-6)


def test_lighting_does_not_depend_on_the_direction_matrix():
    pictures = []
    mirrored = ImageGeometry((0, SIZE - 1) * 3, (SIZE - 1, SIZE - 1, 0), (1, 1, 1), _MIRRORED)
    for geometry in (None, mirrored):
        hands = Hands(ball_image(geometry))
        hands.press("space")
        pictures.append(hands.picture())
    np.testing.assert_allclose(*pictures, atol=3)
    assert pictures[0][120, 120].max() > 200


_MIRRORED = (-1.0, 0, 0, 0, -1, 0, 0, 0, 1)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 0, 2)])
def test_axes_of_any_order_keep_their_values(order, rng):
    values = rng.uniform(size=(5, 4, 3))
    image = image_with(values.ravel(), (3, 4, 5))
    direction = np.eye(3)[list(order)] * [1, -1, -1] @ TURNED
    configured(image, DirectionMatrix=direction.ravel(), Spacing=(1, 2, 3), Origin=(7, 8, 9))
    drawn = scalar_image(image)
    before, after = (ImageGeometry.of_image(image).grid for image in (image, drawn))
    assert (np.diag(after.direction) > 0).all()
    pairs = [
        {tuple(np.round(point, 6)): value for point, value in zip(grid.points().tolist(), flat)}
        for grid, flat in (
            (before, values.ravel()),
            (after, arrays.to_numpy(drawn.GetPointData().GetScalars())),
        )
    ]
    assert pairs[0] == pairs[1]


# Each builds a shader. First the type of CT images, and a type that VTK's textures lack.
_TYPES = (VTK_SHORT, VTK_LONG_LONG, *(VTK_BIT, VTK_SIGNED_CHAR, VTK_UNSIGNED_SHORT, VTK_INT))


@pytest.mark.parametrize(
    "vtk_type",
    [
        pytest.param(vtk_type, marks=[pytest.mark.matrix] * (i > 1))
        for i, vtk_type in enumerate(_TYPES)
    ],
)
def test_an_image_of_any_type_is_shown(vtk_type):
    image = ball_image()
    data = image.GetPointData()
    array = add_array(data, "values", arrays.to_numpy(data.GetScalars()) > 100, vtk_type)
    data.SetScalars(array)
    hands = Hands(image)
    hands.press("h")
    hands.press("space")
    picture = hands.picture()
    assert picture[120, 120].max() > 100 > picture[5, 5].max()
    drawn = scalar_image(image).GetPointData().GetScalars()
    np.testing.assert_array_equal(arrays.to_numpy(drawn), arrays.to_numpy(array))


def test_presets_follow_the_values(rng):
    air, brain = rng.normal(5, 3, 5000), rng.normal(100, 10, 5000)
    (preset, *_) = transfer_functions.presets_of(np.r_[air, brain], False)
    opacity = transfer_functions.opacity(preset, np.array([5.0, 100.0]))
    assert opacity[0] == 0
    assert opacity[1] > 0.2
    hounsfield = np.r_[rng.normal(-1000, 20, 900), rng.normal(40, 20, 900), rng.normal(900, 90, 90)]
    preset, bone, _, *_ = transfer_functions.presets_of(hounsfield, False)
    assert "CT" in preset.name
    assert transfer_functions.opacity(bone, np.array([40.0, 900.0])).tolist() == [
        0,
        pytest.approx(0.7, abs=0.1),
    ]
    few_below_air = np.r_[np.full(5, -700), np.linspace(0, 30000, 2000)]
    preset, *_ = transfer_functions.presets_of(few_below_air, False)
    assert preset.name == "MR, solid"
    (preset,) = transfer_functions.presets_of(np.repeat([0, 1, 7], 50), True)
    assert preset.is_nearest
    assert transfer_functions.opacity(preset, np.array([0, 1, 7])).tolist() == [0, 0.85, 0.85]


def test_labels_of_a_file_are_segments():
    image = ball_image()
    metadata.store(image, metadata.LABEL_ARRAYS, ["density"])
    hands = Hands(image)
    hands.press("v")
    assert hands.message == "segments"


def test_a_mesh_is_colored_by_its_scalars():
    mesh = ball_mesh()
    hands = Hands(add_scalars(mesh, "height", np.arange(mesh.GetNumberOfPoints())))
    before = hands.picture()
    hands.press("v")
    assert hands.message == "by height"
    assert np.abs(hands.picture() - before).mean() > 1


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["none.vti"], "there is no file `none.vti`"),
        (["empty.vti"], "`empty.vti`"),
        (["text.txt"], "cannot read an image or a mesh from `text.txt`"),
        (["ball.vti", "empty.csv"], "`empty.csv` holds no control points"),
        (
            ["ball.vti", "--deformed", "empty.csv"],
            "`--deformed` has the new positions of handles",
        ),
        (["ball.vti"], "`vtk-mls view` without `--window` needs none"),
    ],
)
def test_errors_of_the_command(arguments, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    io.write_dataset(ball_image(), "ball.vti")
    for name in ("empty.vti", "empty.csv", "text.txt"):
        (tmp_path / name).write_text("")
    status, stdout, stderr = run("view", *arguments, "--window", DISPLAY="", WAYLAND_DISPLAY="")
    assert status == 1
    assert stdout == ""
    assert sentence in stderr
    assert stderr.count("\n") == 1


@pytest.mark.parametrize("data", [ball_image, ball_mesh])
def test_handles_are_on_and_in_a_ball(data):
    hands = Hands(data())
    for count in (27, 64, 125):
        rest = hands.state.rest
        assert 0.9 * count < len(rest) <= count
        radius = np.linalg.norm(rest - MIDDLE, axis=1)
        assert radius.max() < SIZE / 3 + 1
        assert (np.abs(radius - SIZE / 3) < 1).sum() >= count / 2
        hands.press("l")
    distances = np.linalg.norm(rest - rest[:, None], axis=2) + 99 * np.eye(len(rest))
    assert distances.min() > 0.5


def test_a_sheet_has_one_layer():
    sheet = vtkPlaneSource()
    sheet.SetResolution(10, 10)
    rest = Hands(output_of(sheet)).editor.state.rest
    assert len(rest) == 9
    np.testing.assert_allclose(rest[:, 2], 0, atol=1e-9)


def test_no_handles_between_two_balls():
    append = vtkAppendPolyData()
    for x in (0, 10):
        append.AddInputData(ball((x, 0, 0), 2, 8))
    rest = Hands(output_of(append)).editor.state.rest
    assert len(rest) > 15
    assert np.abs(np.abs(rest[:, 0] - 5) - 5).max() < 2.01
    assert set(rest[:, 0] > 5) == {False, True}


def test_points_without_cells():
    points = output_of(vtkPointSource(), NumberOfPoints=500).GetPoints()
    positions = arrays.to_numpy(points.GetData())
    rest = Hands(polydata_of(positions)).editor.state.rest
    assert len(rest) > 15
    distances = np.linalg.norm(positions - rest[:, None], axis=2).min(axis=1)
    np.testing.assert_allclose(distances, 0, atol=1e-6)


def test_a_single_point_has_one_handle():
    assert Hands(polydata_of([(3, 4, 5)])).editor.state.rest.tolist() == [[3, 4, 5]]


def test_an_empty_image_has_all_handles():
    image = ball_image()
    arrays.to_numpy(image.GetPointData().GetScalars())[:] = 0
    assert len(Hands(image).editor.state) == 27
