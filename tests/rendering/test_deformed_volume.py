"""A volume drawn through the map style like the resampled one, also with few rays."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from drawing import (
    MIDDLE,
    PIXELS,
    SIZE,
    Scene,
    assert_alike,
    drawn_volume,
    image_of,
    phantom,
    volume_of,
)
from pairwise import one_of, paired, rare
from pipelines import ball
from vtk_fixtures import FAST, TURNED, make_image
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction, vtkPlane
from vtkmodules.vtkImagingCore import vtkImageShiftScale
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkColorTransferFunction,
    vtkPolyDataMapper,
    vtkRenderWindow,
)
from vtkmodules.vtkRenderingVolume import (
    vtkFixedPointVolumeRayCastMapper,
    vtkGPUVolumeRayCastMapper,
)
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

from vtk_mls import KINDS, Deformation, Grid, HalfPlane, Plane, Sampling, Surface
from vtk_mls.rendering import DeformedVolume, pace
from vtk_mls.rendering.pace import adjust_rays, usual_step
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

pytestmark = pytest.mark.usefixtures("opengl")

VALUES, SOURCE = phantom(), Grid((SIZE,) * 3)
REST = np.array([(x, y, z) for x in (10, 37) for y in (10, 37) for z in (10, 37)], float)
NORMAL = np.array([1, 0.3, 0.2]) / np.linalg.norm([1, 0.3, 0.2])
CENTER = np.full(3, MIDDLE)
CUTS = {
    "plane": Plane(CENTER, NORMAL),
    "half-plane": HalfPlane(CENTER, NORMAL, (0, 0, 1)),
    "polygon": Surface.polygon(CENTER + [(0, -20, 4), (0, 20, 4), (0, 20, 30), (0, -20, 30)]),
    "bent surface": Surface(
        CENTER + np.array([(abs(y) / 4, y, z) for y in (-20, 0, 20) for z in (0, 25)]),
        [(0, 1, 2), (1, 2, 3), (2, 3, 4), (3, 4, 5)],
    ),
}


def deformation(left=(0, 0, 0), right=(10, 2, 0), kind="rigid", cuts=(), **options):
    """The two sides of the middle are moved by vectors."""
    is_right = (REST - MIDDLE) @ NORMAL > 0
    moved = REST + np.where(is_right[:, None], right, left)
    return Deformation(REST, moved, kind, cuts=cuts, device=FAST, **options)


def finer(grid):
    """With twice as many points along each axis."""
    return Grid(2 * np.array(grid.dimensions), grid.origin, grid.spacing / 2, grid.direction)


def resampled(deformation, values=VALUES, hides_outside=False, target=None):
    """The image that a filter would give."""
    target = target or deformation.fitted_grid(SOURCE)
    if hides_outside:
        target = finer(target)
    image = deformation.resample([values], Sampling(SOURCE, target))[0]
    hidden = deformation.void_field(target)
    if hides_outside:
        origins = deformation.backward(target.points())
        hidden |= ~SOURCE.covers(SOURCE.index_of(origins)).reshape(target.shape)
    return image_of(image, target, hidden if hidden.any() else None)


def pictures(d, values=VALUES, prepare=None, hides_outside=False, **style):
    """Pictures through the map, and of the resampled volume; detaching restores the volume."""
    scene = Scene(volume_of(resampled(d, values, hides_outside), **style))
    if prepare:
        prepare(scene)
    expected = scene.picture()
    _, scene, drawn = drawn_volume(image_of(values), **style)
    if prepare:
        prepare(scene)
    before = scene.picture()
    drawn.update(d)
    picture = scene.picture()
    assert drawn.failure is None
    drawn.detach()
    np.testing.assert_array_equal(scene.picture(), before)
    assert np.abs(picture - before).mean() > 1, "the deformation is not visible"
    return picture, expected


def mapper_in(scene):
    return scene.renderer.GetVolumes().GetItemAsObject(0).GetMapper()


# Styles


def _with(**values):
    """A function that sets properties of the mapper."""
    return lambda scene: configured(mapper_in(scene), **values)


_PLANE = configured(vtkPlane(), Origin=CENTER, Normal=(0.5, 1, 0.2))


def _with_ball(opacity):
    def prepare(scene):
        mapper = configured(vtkPolyDataMapper(), InputData=ball((MIDDLE, 0, MIDDLE), 15, 8))
        actor = configured(vtkActor(), Mapper=mapper)
        actor.GetProperty().SetOpacity(opacity)
        scene.renderer.AddActor(actor)
        if opacity < 1:
            scene.window.SetAlphaBitPlanes(True)
            scene.renderer.SetUseDepthPeeling(True)
            scene.renderer.SetUseDepthPeelingForVolumes(True)

    return prepare


def _parallel(scene):
    configured(scene.renderer.GetActiveCamera(), ParallelProjection=True, ParallelScale=SIZE)


def _zoomed(scene):
    """Zoom in: VTK hides half a voxel more at the ends of the volume."""
    scene.renderer.GetActiveCamera().Zoom(2.5)


def _gradient_opacity():
    function = vtkPiecewiseFunction()
    function.AddPoint(0, 0)
    function.AddPoint(20, 1)
    return function


TWO = np.stack([VALUES, np.roll(VALUES, 6, 2)], axis=-1)
FOUR = np.stack([VALUES, 255 - VALUES, VALUES // 2, VALUES], axis=-1)
# compared where there are samples: VTK draws a value without samples, we do not
PROJECTED = {"prepare": _zoomed, "hides_outside": True}
STYLES = {
    "shaded": {},
    "not shaded": {"Shade": False},
    "gradient opacity": {"GradientOpacity": _gradient_opacity()},
    "maximum": {"blend": "MaximumIntensity"},
    "minimum": {"blend": "MinimumIntensity", "values": 255 - VALUES, **PROJECTED},
    "average": {"blend": "AverageIntensity", **PROJECTED},
    "additive": {"blend": "Additive", **PROJECTED},
    "isosurface": {"blend": "IsoSurface"},
    "slice": {"blend": "Slice", "SliceFunction": _PLANE},
    "independent components": {"values": TWO, "components": 2},
    "colors": {"values": FOUR, "components": 4, "IndependentComponents": False},
    "cropped": {"prepare": _with(Cropping=True, CroppingRegionPlanes=(8, 45, -100, 30, 0, 47))},
    "clipped": {"prepare": lambda scene: mapper_in(scene).AddClippingPlane(_PLANE)},
    "opaque geometry": {"prepare": _with_ball(1.0)},
    "peeled geometry": {"prepare": _with_ball(0.4)},
    "parallel": {"prepare": _parallel},
    "jittered": {"prepare": _with(UseJittering=True)},
    "shadowed": {"prepare": _with(GlobalIlluminationReach=0.5, VolumetricScatteringBlending=0.5)},
}
BLENDED = ["shaded", *(name for name, style in STYLES.items() if "blend" in style)]


@pytest.mark.parametrize("style", one_of(3, STYLES))
def test_every_style_equals_that_of_the_resampled_volume(style):
    assert_alike(*pictures(deformation(), **STYLES[style]))


def test_a_smart_mapper():
    mapper = vtkSmartVolumeMapper()
    mapper.SetRequestedRenderModeToGPU()
    mapper.InteractiveAdjustSampleDistancesOff()
    (_, scene, drawn), d = drawn_volume(image_of(VALUES), mapper=mapper), deformation()
    drawn.update(d)
    assert_alike(scene.picture(), Scene(volume_of(resampled(d))).picture())


@pytest.mark.parametrize("is_label_map", [False, True])
def test_masks(is_label_map):
    d = deformation()
    z, y, x = np.meshgrid(*[np.arange(SIZE) - MIDDLE] * 3, indexing="ij")
    mask = np.where(x**2 + y**2 + z**2 < 18**2, 1 + (x > 0) if is_label_map else 255, 0)
    mask = mask.astype(np.uint8)

    def drawn(image, mask):
        volume = volume_of(image)
        mapper = volume.GetMapper()
        mapper.SetMaskInput(mask)
        if is_label_map:
            mapper.SetMaskTypeToLabelMap()
            mapper.SetMaskBlendFactor(0.7)
            for label, color in ((1, (1, 0, 0)), (2, (0, 1, 0))):
                function = vtkColorTransferFunction()
                function.AddRGBPoint(0, *color)
                volume.GetProperty().SetLabelColor(label, function)
                volume.GetProperty().SetLabelScalarOpacity(
                    label, volume.GetProperty().GetScalarOpacity()
                )
        else:
            mapper.SetMaskTypeToBinary()
        return volume

    volume = drawn(image_of(VALUES), image_of(mask))
    scene = Scene(volume)
    DeformedVolume(volume, scene.renderer).update(d)
    fine = finer(d.fitted_grid(SOURCE))  # hides the steps of labels
    moved = d.resample([mask], Sampling(SOURCE, fine, "nearest"))[0]
    values = d.resample([VALUES], Sampling(SOURCE, fine))[0]
    assert_alike(
        scene.picture(),
        Scene(drawn(image_of(values, fine), image_of(moved, fine))).picture(),
        mean=1.5,
        p99=30,
    )


# Maps


@pytest.mark.parametrize("kind", one_of(len(KINDS), KINDS))
def test_every_kind(kind):
    assert_alike(*pictures(deformation(kind=kind)))


@paired(
    cut=CUTS,
    moved=[((-5, 0, 0), (5, 0, 0)), ((0, 0, 0), (10, 2, 0)), ((5, 0, 2), (7, 0, 2))],
    kind=["rigid", *rare("affine")],
)
def test_voids_of_every_cut(cut, moved, kind):
    d = deformation(*moved, kind, cuts=CUTS[cut])
    assert_alike(*pictures(d), mean=1.5, p99=30)


@pytest.mark.parametrize("style", one_of(3, BLENDED))
def test_a_cut_in_every_blend_mode(style):
    d = deformation((-6, 0, 0), (6, 0, 0), cuts=CUTS["half-plane"])
    assert_alike(*pictures(d, **STYLES[style]), mean=1.5, p99=30)


CROSSING = {
    "planes": [CUTS["plane"], Plane(CENTER, (0, 1, 0))],
    "half-planes": [CUTS["half-plane"], HalfPlane(CENTER, (0, 1, 0.1), (0, 0, 1))],
    "plane and half-plane": [CUTS["plane"], HalfPlane(CENTER, (0, 1, 0.1), (0, 0, 1))],
    "polygon and half-plane": [CUTS["polygon"], HalfPlane(CENTER, (0, 1, 0.1), (0, 0, 1))],
}


@pytest.mark.parametrize("cuts", one_of(2, CROSSING))
@pytest.mark.parametrize("moved", [((-5, 0, 0), (5, 2, 0)), ((0, 0, 0), (10, 2, 0))])
def test_cuts_that_cross(cuts, moved):
    assert_alike(*pictures(deformation(*moved, cuts=CROSSING[cuts])), mean=1.5, p99=30)


def test_cuts_in_the_deformed_frame():
    d = deformation((-6, 0, 0), (6, 0, 0), cuts=CUTS["half-plane"], cut_frame="deformed")
    assert_alike(*pictures(d), mean=1.5, p99=30)


def test_the_box_grows_and_shrinks_with_the_deformation():
    volume = volume_of(image_of(VALUES))
    scene = Scene(volume, distance=9 * SIZE)
    drawn = DeformedVolume(volume, scene.renderer)
    for right in ((100, 40, 0), (0, 0, 0.5)):
        d = deformation(right=right)
        drawn.update(d)
        expected = Scene(volume_of(resampled(d)), distance=9 * SIZE).picture()
        assert_alike(scene.picture(), expected)
    low, high = np.reshape(volume.GetBounds(), (3, 2)).T
    assert (high - low < 2 * SIZE).all()


PARTS = {
    "the input's grid": SOURCE,
    "a part": Grid((30, 40, 20), (20.3, 4, 12), (1, 0.5, 1.4)),
    "beside the volume at rest": Grid((30, 48, 48), (60, 0, 0)),
}


def test_only_the_part_within_an_output_grid_is_drawn():
    volume, scene, drawn = drawn_volume(image_of(VALUES))
    d = deformation(right=(40, 2, 0))
    drawn.update(d)
    pictures = [scene.picture()]
    for grid in PARTS.values():
        drawn.update(d, within=grid)
        pictures.append(scene.picture())
        assert_alike(pictures[-1], Scene(volume_of(resampled(d, target=grid))).picture())
        stretched = volume.GetMapper().GetInput()
        drawn.update(
            deformation(right=(39, 2, 0)), within=Grid(grid.dimensions, grid.origin, grid.spacing)
        )
        assert volume.GetMapper().GetInput() is stretched, "the volume was uploaded again"
    drawn.update(d)
    assert_alike(scene.picture(), pictures[0], mean=0.2)
    for first, second in itertools.combinations(pictures, 2):
        assert np.abs(first - second).mean() > 1


# Data


@pytest.mark.parametrize("start", [(0, 0, 0), (7, -3, 20)])
def test_an_oblique_image(start):
    image, place = image_of(VALUES), {"origin": (5, -3, 20), "spacing": (1.2, 0.8, 1.0)}
    geometry = ImageGeometry.of_image(make_image((SIZE,) * 3, start, TURNED, **place))
    geometry.apply_to(image)
    grid = geometry.grid
    rest = grid.at(REST)
    d = Deformation(rest, rest + (REST[:, :1] > MIDDLE) * [6, 4, 2], device=FAST)
    target = d.fitted_grid(grid)
    expected = image_of(d.resample([VALUES], Sampling(grid, target))[0], target)
    focal = grid.at(CENTER[None])[0]
    volume = volume_of(image)
    scene = Scene(volume, focal=focal)
    before = scene.picture()
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.update(d)
    assert_alike(scene.picture(), Scene(volume_of(expected), focal=focal).picture())
    drawn.detach()
    np.testing.assert_array_equal(scene.picture(), before)


def test_values_of_cells():
    image = image_of(np.zeros((SIZE + 1,) * 3, np.uint8))
    image.SetOrigin(-0.5, -0.5, -0.5)
    image.GetCellData().SetScalars(image_of(VALUES).GetPointData().GetScalars())
    volume = volume_of(image)
    volume.GetMapper().SetScalarModeToUseCellData()
    scene, d = Scene(volume), deformation()
    DeformedVolume(volume, scene.renderer).update(d)
    assert_alike(scene.picture(), Scene(volume_of(resampled(d))).picture())


def test_changes_of_the_data_are_followed():
    scaled = configured(vtkImageShiftScale(), InputData=image_of(VALUES))
    scaled.SetOutputScalarTypeToUnsignedChar()
    volume, d = volume_of(image_of(VALUES)), deformation()
    volume.GetMapper().SetInputConnection(scaled.GetOutputPort())
    scene = Scene(volume)
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.update(d)
    first = scene.picture()
    scaled.SetScale(0.6)
    other = scene.picture()
    assert np.abs(first - other).mean() > 1
    paler = (VALUES * 0.6).astype(np.uint8)
    assert_alike(other, Scene(volume_of(resampled(d, paler))).picture())
    volume.GetMapper().SetInputData(image_of(VALUES))  # another input
    assert_alike(scene.picture(), first, mean=0.2)
    drawn.detach()
    np.testing.assert_array_equal(scene.picture(), Scene(volume_of(image_of(VALUES))).picture())


def test_one_move_uploads_one_map_and_nothing_else():
    volume, scene, drawn = drawn_volume(image_of(VALUES))
    drawn.update(deformation())
    scene.picture()
    stretched = volume.GetMapper().GetInput()
    time = stretched.GetMTime()
    for x in range(1, 4):
        drawn.update(deformation(right=(10 - x, 2, 0)))
        drawn.update(deformation(right=(10 - x, 1, 0)))  # not drawn, not uploaded
        scene.picture()
        scene.picture()
    assert drawn.uploads == 4
    assert volume.GetMapper().GetInput() is stretched
    assert stretched.GetMTime() == time


def test_two_windows():
    image, d = image_of(VALUES), deformation()
    volumes = [volume_of(image) for _ in range(2)]
    scenes = [Scene(volume) for volume in volumes]
    for volume, scene in zip(volumes, scenes):
        DeformedVolume(volume, scene.renderer).update(d)
    first, second = (scene.picture() for scene in scenes)
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(scenes[0].picture(), first)


def test_a_renderer_moves_to_another_window():
    _, scene, drawn = drawn_volume(image_of(VALUES))
    drawn.update(deformation())
    first, old = scene.picture(), scene.window
    scene.window = configured(vtkRenderWindow(), OffScreenRendering=True, MultiSamples=0)
    scene.window.SetSize(PIXELS, PIXELS)
    old.RemoveRenderer(scene.renderer)
    scene.window.AddRenderer(scene.renderer)
    np.testing.assert_array_equal(scene.picture(), first)


def test_errors_name_the_reason():
    renderer = Scene().renderer
    on_cpu = volume_of(image_of(VALUES), mapper=vtkFixedPointVolumeRayCastMapper())
    with pytest.raises(TypeError, match="`volume` must have a vtkGPU.*, got vtkFixed"):
        DeformedVolume(on_cpu, renderer)
    flat = DeformedVolume(volume_of(image_of(VALUES[:1])), renderer)
    for _ in range(2):
        with pytest.raises(ValueError, match=r"must have at least two points .*\(48, 48, 1\)"):
            flat.update(deformation())
    empty = volume_of(image_of(VALUES))
    empty.SetMapper(vtkGPUVolumeRayCastMapper())
    with pytest.raises(ValueError, match="the mapper of `volume` must have one input"):
        DeformedVolume(empty, renderer)


def blurred(picture, size=6):
    """Means of squares of pixels."""
    height, width, _ = picture.shape
    squares = picture.reshape(height // size, size, width // size, size, 3)
    return squares.mean(axis=(1, 3))


def test_pictures_during_movement_have_fewer_rays_and_the_same_colors(monkeypatch):
    volume, scene, drawn = drawn_volume(image_of(phantom()))
    mapper = volume.GetMapper()
    drawn.update(deformation())
    resting = scene.picture()
    monkeypatch.setattr(pace, "_PICTURE_SECONDS", mapper.GetTimeToDraw() / 6)
    scene.window.SetDesiredUpdateRate(15)
    adjust_rays(mapper, scene.window)
    assert mapper.GetImageSampleDistance() == 3  # at least 6 times fewer
    moving = scene.picture()
    assert np.abs(moving - resting).mean() > 0.1
    assert np.abs(blurred(moving) - blurred(resting)).mean() < 1
    monkeypatch.setattr(pace, "_PICTURE_SECONDS", 1e-6)
    adjust_rays(mapper, scene.window)
    assert mapper.GetImageSampleDistance() == 4
    scene.window.SetDesiredUpdateRate(1e-4)
    adjust_rays(mapper, scene.window)
    np.testing.assert_array_equal(scene.picture(), resting)


def test_the_first_picture_during_movement_has_few_rays():
    volume = volume_of(image_of(phantom()))
    scene = Scene(volume)
    scene.window.SetDesiredUpdateRate(15)
    adjust_rays(volume.GetMapper(), scene.window)
    assert volume.GetMapper().GetImageSampleDistance() == 4


@pytest.mark.parametrize("size", [30, 120])
def test_steps_are_those_of_the_smart_mapper(size):
    image = configured(image_of(phantom(size)), Spacing=(1, 2, 0.6))
    mapper = configured(vtkSmartVolumeMapper(), InteractiveAdjustSampleDistances=False)
    mapper.SetRequestedRenderModeToGPU()
    volume = volume_of(image, mapper=mapper)
    mapper.SetSampleDistance(-1)  # automatic
    expected = Scene(volume).picture()
    other = volume_of(image)
    other.GetMapper().SetSampleDistance(usual_step(image))
    other.SetProperty(volume.GetProperty())
    np.testing.assert_array_equal(Scene(other).picture(), expected)
    other.GetMapper().SetSampleDistance(1.01 * usual_step(image))
    assert not np.array_equal(Scene(other).picture(), expected)
