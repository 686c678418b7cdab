"""Tests of the module MLS Deform that run in slicer-core's Python; see `test_slicer_module`."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import slicer
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

MODULE = Path(__file__).resolve().parents[2] / "slicer/MLSDeform"
sys.path.insert(0, str(MODULE))
from MLSDeformLib import deform_logic  # noqa: E402

RNG = np.random.default_rng(0)
TURNED = [[0.8, -0.6, 0, 5], [0.6, 0.8, 0, -7], [0, 0, 1, 3], [0, 0, 0, 1]]


def new_scene():
    """A scene that knows markups and segmentations, as that of the application."""
    scene = slicer.vtkMRMLScene()
    application, markups_logic = slicer.vtkMRMLApplicationLogic(), slicer.vtkSlicerMarkupsLogic()
    for logic in (application, markups_logic, slicer.vtkSlicerSegmentationsModuleLogic()):
        logic.SetMRMLScene(scene)
        _ALIVE.append(logic)
    application.SetModuleLogic("Markups", markups_logic)
    slicer.vtkMRMLThreeDViewDisplayableManagerFactory.GetInstance().SetMRMLApplicationLogic(
        application
    )
    return scene


_ALIVE: list = []  # logics live as long as their scenes


@pytest.fixture
def scene():
    return new_scene()


@pytest.fixture
def logic(scene):
    return deform_logic.DeformLogic(scene)


def volume(scene, size=40, spacing=3.0):
    """A volume of smooth values around the origin, in LPS as scanners write it."""
    z, y, x = np.mgrid[:size, :size, :size] / size
    values = (np.sin(7 * x) + np.cos(5 * y) + np.sin(6 * z)).astype(np.float32)
    image = vtk.vtkImageData()
    image.SetDimensions(size, size, size)
    image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=True))
    node = scene.AddNewNodeByClass("vtkMRMLScalarVolumeNode", "volume")
    node.SetAndObserveImageData(image)
    half = (size - 1) * spacing / 2
    matrix = vtk.vtkMatrix4x4()
    for axis, sign in enumerate((-1, -1, 1)):
        matrix.SetElement(axis, axis, sign * spacing)
        matrix.SetElement(axis, 3, -sign * half)
    node.SetIJKToRASMatrix(matrix)
    return node


def model(scene):
    sphere = vtk.vtkSphereSource()
    sphere.SetRadius(12)
    sphere.SetCenter(10, -15, 5)
    sphere.Update()
    node = scene.AddNewNodeByClass("vtkMRMLModelNode", "bone")
    node.SetAndObservePolyData(sphere.GetOutput())
    return node


def segmentation(scene):
    node = scene.AddNewNodeByClass("vtkMRMLSegmentationNode", "bones")
    node.AddSegmentFromClosedSurfaceRepresentation(model(scene).GetPolyData(), "one", [1, 0, 0])
    return node


def markups(scene, places, class_name="vtkMRMLMarkupsFiducialNode"):
    node = scene.AddNewNodeByClass(class_name, "points")
    for place in places:
        node.AddControlPointWorld(vtk.vtkVector3d(*place))
    return node


def linear(scene, matrix):
    node = scene.AddNewNodeByClass("vtkMRMLLinearTransformNode")
    copy = vtk.vtkMatrix4x4()
    copy.DeepCopy(np.ravel(matrix).tolist())
    node.SetMatrixTransformToParent(copy)
    return node


def moved(general, points):
    return np.array([general.TransformPoint(point) for point in points])


def from_parent(node):
    return lambda points: moved(node.GetTransformFromParent(), points)


def set_places(node, places):
    for i, place in enumerate(places):
        node.SetNthControlPointPositionWorld(i, *place)


def dragged(scene, logic, kind="rigid", parent=None, curve=False, cut=False, bone=None, **options):
    """A deformation with 12 points, or what is asked for, and p and q of the points."""
    data = volume(scene)
    transform = logic.create(data)
    if parent is not None:
        transform.SetAndObserveTransformNodeID(parent.GetID())
        data.SetAndObserveTransformNodeID(parent.GetID())
    p = RNG.uniform(-45, 45, (12, 3))
    q = p + RNG.uniform(-4, 4, (12, 3))
    set_places(logic.add_handle(transform, markups(scene, p)), q)
    if curve:
        nodes = np.array([[-40, 0, 0], [-10, 10, 0], [10, -5, 8], [40, 0, 0.0]])
        curve = markups(scene, nodes, "vtkMRMLMarkupsCurveNode")
        set_places(logic.add_handle(transform, curve), nodes + [0, 3, 3])
    if cut:
        plane = scene.AddNewNodeByClass("vtkMRMLMarkupsPlaneNode")
        plane.SetCenter(0, 0, 2)
        plane.SetNormal(0, 0.6, 0.8)
        logic.add_cut(transform, plane)
    if bone:
        node = bone(scene)
        node.SetAndObserveTransformNodeID(linear(scene, TURNED).GetID())
        logic.add_bone(transform, node)
    logic.set_options(transform, kind=kind, **options)
    return transform, p, q


SCENES = [
    *({"kind": kind} for kind in deform_logic.KINDS),
    *({"kind": kind, "parent": True} for kind in ("rigid", "affine", "spline")),
    *({"kind": kind, "curve": True} for kind in ("rigid", "similarity", "spline")),
    *({"kind": k, "bone": bone} for k in ("rigid", "affine") for bone in (model, segmentation)),
    {"kind": "rigid", "steps": 4},
    {"kind": "rigid", "steps": 0},
    {"kind": "affine", "smoothing": 5.0},
    {"kind": "spline", "parent": True, "smoothing": 2.0},
    {"kind": "rigid", "parent": True, "bone": model},
]


@pytest.mark.parametrize("case", range(len(SCENES)))
def test_the_transform_is_that_of_the_deformation(scene, logic, case):
    options = dict(SCENES[case])
    parent = linear(scene, TURNED) if options.pop("parent", False) else None
    transform, p, q = dragged(scene, logic, parent=parent, **options)
    assert logic.update(transform), logic.message
    grid, back = logic.grid(transform), logic.deformation(transform).backward
    # exact at nodes of the grid
    nodes = RNG.integers(20, np.subtract(grid.dimensions, 20), (1000, 3))
    v = grid.origin + nodes * grid.spacing
    assert from_parent(transform)(v) == pytest.approx(back(v), abs=1e-4 * grid.spacing[0])
    inside = RNG.uniform(-45, 45, (1000, 3))
    if not options.get("bone"):  # the map around a bone has a kink at its surface
        error = np.linalg.norm(from_parent(transform)(inside) - back(inside), axis=1)
        assert np.quantile(error, 0.99) < 1e-3 * grid.spacing[0]
    # In the world, a point moved by its transform and back is where it was.
    way = vtk.vtkGeneralTransform()
    transform.GetTransformFromWorld(way)
    meets_all = options["kind"] != "auto" and not {"smoothing", "bone"} & {*options}
    if parent is None and meets_all:
        assert moved(way, q) == pytest.approx(p, abs=0.2 * grid.spacing[0])


def test_a_cut_separates(scene, logic):
    transform, *_ = dragged(scene, logic, cut=True)
    assert logic.update(transform), logic.message
    grid = logic.grid(transform)
    v = grid.origin + RNG.integers(20, np.subtract(grid.dimensions, 20), (1000, 3)) * grid.spacing
    assert from_parent(transform)(v) == pytest.approx(
        logic.deformation(transform).backward(v), abs=1e-4 * grid.spacing[0]
    )
    assert logic.deformation(transform).void(v).any()


def test_the_inverse_moves_models_and_markups_forward(scene, logic):
    transform, *_ = dragged(scene, logic)
    assert logic.update(transform)
    x = RNG.uniform(-40, 40, (1000, 3))
    expected = logic.deformation(transform).forward(x)
    found = moved(transform.GetTransformToParent(), x)
    is_fine = np.isfinite(expected).all(axis=1)
    assert is_fine.mean() > 0.95
    assert np.quantile(np.linalg.norm(found - expected, axis=1)[is_fine], 0.99) < 0.01
    points = markups(scene, x[is_fine][:5])
    points.SetAndObserveTransformNodeID(transform.GetID())
    places = np.array([points.GetNthControlPointPositionWorld(i) for i in range(5)])
    assert places == pytest.approx(expected[is_fine][:5], abs=0.05)


def test_hardened_volume_is_that_of_the_field(scene, logic):
    """The values are compared with SimpleITK's, which must not run beside Slicer's own ITK."""
    transform, *_ = dragged(scene, logic)
    assert logic.update(transform)
    data = logic.data(transform)
    before = vtk_to_numpy(data.GetImageData().GetPointData().GetScalars()).reshape((40,) * 3).copy()
    data.SetAndObserveTransformNodeID(transform.GetID())
    assert data.HardenTransform()
    image, matrix = data.GetImageData(), vtk.vtkMatrix4x4()
    data.GetIJKToRASMatrix(matrix)
    after = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])
    ijk = RNG.integers(8, np.subtract(image.GetDimensions(), 8), (1000, 3))
    matrix = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    origin = logic.deformation(transform).backward(ijk @ matrix[:3, :3].T + matrix[:3, 3])
    values = after[tuple(ijk.T[::-1])]
    np.savez(os.environ["HARDENED"], before=before, places=origin * [-1, -1, 1], values=values)


@pytest.mark.parametrize("make", [model, segmentation])
def test_hardened_surface_is_moved_forward(scene, logic, make):
    data = make(scene)
    before = _points(data)
    transform = logic.create(data)
    p = before[:: len(before) // 8]
    set_places(logic.add_handle(transform, markups(scene, p)), p + RNG.uniform(-2, 2, p.shape))
    assert logic.update(transform), logic.message
    expected = logic.deformation(transform).forward(before)
    data.SetAndObserveTransformNodeID(transform.GetID())
    assert data.HardenTransform()
    found = _points(data)
    if make is segmentation:  # which Slicer samples again
        expected, found = ([x.min(axis=0), x.max(axis=0)] for x in (expected, found))
    tolerance = 0.3 if make is segmentation else 0.02
    assert np.array(found) == pytest.approx(np.array(expected), abs=tolerance)


def _points(data):
    (surface,) = deform_logic._surfaces(data)
    return vtk_to_numpy(surface.GetPoints().GetData()).astype(float)


def points_along(transform):
    """The points of the grid along its longest edge."""
    return max(transform.GetTransformFromParent().GetDisplacementGrid().GetDimensions())


def test_a_drag_is_coarse_and_its_release_fine(scene, logic):
    transform, _, q = dragged(scene, logic)
    logic.follow(transform)
    node = logic.handles(transform)[0][1]
    assert points_along(transform) == deform_logic.FINE
    node.InvokeEvent(node.PointStartInteractionEvent)
    node.SetNthControlPointPositionWorld(0, *(q[0] + [3, 0, 0]))
    assert points_along(transform) == deform_logic.COARSE
    node.InvokeEvent(node.PointEndInteractionEvent)
    assert points_along(transform) == deform_logic.FINE
    place = from_parent(transform)([q[0] + [3, 0, 0]])
    rest = logic.handles(transform)[0][0].GetNthControlPointPositionWorld(0)
    assert place[0] == pytest.approx(rest, abs=0.05)


def test_everything_that_moves_updates_the_transform(scene, logic):
    transform, *_ = dragged(scene, logic, bone=model)
    plane = scene.AddNewNodeByClass("vtkMRMLMarkupsPlaneNode")
    plane.SetCenter(0, 0, 30)
    logic.add_cut(transform, plane)
    logic.follow(transform)
    bone = logic.bones(transform)[0].GetParentTransformNode()
    matrix = vtk.vtkMatrix4x4()
    matrix.SetElement(0, 3, 4)
    rest = logic.handles(transform)[0][0]
    for change in (
        lambda: bone.SetMatrixTransformToParent(matrix),
        lambda: plane.SetCenter(0, 0, 20),
        lambda: rest.SetNthControlPointPositionWorld(0, 1, 2, 3),
        lambda: logic.set_options(transform, smoothing=1.5),
        lambda: logic.remove(transform, plane),
    ):
        old = transform.GetTransformFromParent()
        change()
        assert transform.GetTransformFromParent() is not old
        assert not logic.message


def observed(node):
    events = (*deform_logic._POINT_EVENTS, node.TransformModifiedEvent)
    return [event for event in events if node.HasObserver(event)]


@pytest.mark.parametrize("end", ["unfollow", "handle", "transform", "scene"])
def test_no_observer_is_left(scene, logic, end):
    transform, *_ = dragged(scene, logic)
    rest, node = logic.handles(transform)[0]
    usual = len(observed(markups(scene, [(0, 0, 0)])))
    logic.follow(transform)
    if end == "unfollow":
        logic.unfollow()
    elif end == "handle":
        scene.RemoveNode(rest)
        assert not logic.handles(transform)
    elif end == "transform":
        scene.RemoveNode(transform)
    else:
        scene.Clear()
    assert len(observed(node)) <= usual
    if end != "handle":
        assert not logic._observed


class View:
    """An offscreen 3-D view along z, with Slicer's displayable manager of markups."""

    def __init__(self, scene):
        factory = slicer.vtkMRMLThreeDViewDisplayableManagerFactory.GetInstance()
        if not factory.IsDisplayableManagerRegistered("vtkMRMLMarkupsDisplayableManager"):
            factory.RegisterDisplayableManager("vtkMRMLMarkupsDisplayableManager")
        self.renderer, self.window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetSize(400, 400)
        self.window.AddRenderer(self.renderer)
        self.interactor = vtk.vtkRenderWindowInteractor()
        self.interactor.SetRenderWindow(self.window)
        self.node = scene.AddNewNodeByClass("vtkMRMLViewNode")
        self.managers = factory.InstantiateDisplayableManagers(self.renderer)
        self.managers.SetMRMLDisplayableNode(self.node)
        self.renderer.GetActiveCamera().SetPosition(0, 0, 400)
        self.window.Render()

    def at(self, place):
        self.renderer.SetWorldPoint(*place, 1)
        self.renderer.WorldToDisplay()
        return [round(value) for value in self.renderer.GetDisplayPoint()[:2]]

    def mouse(self, event, pixel):
        """An event of the mouse; True if a markup takes it."""
        self.interactor.SetEventInformation(*pixel, 0, 0, chr(0), 0, None)
        data = slicer.vtkMRMLInteractionEventData()
        data.SetType(event)
        data.SetAttributesFromInteractor(self.interactor)
        data.SetDisplayPosition(pixel)
        data.SetRenderer(self.renderer)
        data.SetViewNode(self.node)
        manager = self.managers.GetDisplayableManagerByClassName("vtkMRMLMarkupsDisplayableManager")
        takes = manager.CanProcessInteractionEvent(data, vtk.reference(0.0))
        return takes and manager.ProcessInteractionEvent(data)


def test_a_drag_by_the_mouse_in_a_view(scene, logic):
    view = View(scene)
    transform = logic.create(volume(scene))
    rest = markups(scene, [(-40, 0, 0), (40, 0, 0), (0, 40, 10), (0, -40, 10)])
    node = logic.add_handle(transform, rest)
    node.CreateDefaultDisplayNodes()
    logic.follow(transform)
    view.window.Render()
    start = view.at(node.GetNthControlPointPositionWorld(1))
    assert view.mouse(vtk.vtkCommand.MouseMoveEvent, start)
    assert view.mouse(vtk.vtkCommand.LeftButtonPressEvent, start)
    for k in range(1, 5):
        pixel = [start[0] + 5 * k, start[1] + 3 * k]
        assert view.mouse(vtk.vtkCommand.MouseMoveEvent, pixel)
        assert points_along(transform) == deform_logic.COARSE
    assert view.mouse(vtk.vtkCommand.LeftButtonReleaseEvent, pixel)
    assert points_along(transform) == deform_logic.FINE
    place = np.array(node.GetNthControlPointPositionWorld(1))
    assert view.at(place) == pytest.approx(pixel, abs=1)
    assert np.linalg.norm(place - (40, 0, 0)) > 5
    assert from_parent(transform)([place])[0] == pytest.approx((40, 0, 0), abs=0.05)


def test_scene_saved_and_loaded(scene, logic, tmp_path):
    transform, *_ = dragged(scene, logic, curve=True, alpha=1.5)
    assert logic.update(transform)
    v = RNG.uniform(-45, 45, (100, 3))
    before = from_parent(transform)(v)
    scene.SetRootDirectory(str(tmp_path))
    for i in range(scene.GetNumberOfNodes()):
        node = scene.GetNthNode(i)
        if node.IsA("vtkMRMLStorableNode") and node.GetSaveWithScene():
            node.AddDefaultStorageNode()
            if storage := node.GetStorageNode():
                ending = storage.GetDefaultWriteFileExtension()
                storage.SetFileName(str(tmp_path / f"{node.GetID()}.{ending}"))
                assert storage.WriteData(node)
    scene.SetURL(str(tmp_path / "scene.mrml"))
    assert scene.Commit()
    other = new_scene()
    other.SetURL(str(tmp_path / "scene.mrml"))
    assert other.Connect()
    again = deform_logic.DeformLogic(other)
    loaded = other.GetFirstNodeByClass("vtkMRMLGridTransformNode")
    assert from_parent(loaded)(v) == pytest.approx(before, abs=1e-3)
    assert again.options(loaded) == logic.options(transform)
    again.follow(loaded)
    assert not again.message
    assert from_parent(loaded)(v) == pytest.approx(before, abs=1e-3)


def test_report_in_a_table(scene, logic):
    transform = logic.create(volume(scene))
    p = RNG.uniform(-45, 45, (30, 3))
    q = p + 3 * np.sin(p / 30)
    q[4] += [15, 0, 0]
    logic.add_handle(transform, markups(scene, p), markups(scene, q))
    table = scene.AddNewNodeByClass("vtkMRMLTableNode")
    logic.report(transform, table)
    assert table.GetNumberOfRows() == 30
    rows = [table.GetCellText(i, 2) for i in range(30)]
    assert [i for i, text in enumerate(rows) if text] == [4]


def wrong_counts(scene, logic, transform):
    logic.add_handle(transform, markups(scene, [(0, 0, 0)]), markups(scene, [(0, 0, 0), (9, 0, 0)]))


def no_data(scene, logic, transform):
    scene.RemoveNode(logic.data(transform))


def spline_with_a_cut(scene, logic, transform):
    logic.add_cut(transform, scene.AddNewNodeByClass("vtkMRMLMarkupsPlaneNode"))
    logic.set_options(transform, kind="spline")


def bone_under_the_transform(scene, logic, transform):
    bone = model(scene)
    bone.SetAndObserveTransformNodeID(transform.GetID())
    logic.add_bone(transform, bone)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (wrong_counts, "the same number"),
        (no_data, "needs a volume"),
        (spline_with_a_cut, "cut"),
        (bone_under_the_transform, "must not be under the transform"),
    ],
)
def test_what_does_not_fit_is_one_sentence(scene, make, words):
    shown = []
    logic = deform_logic.DeformLogic(scene, lambda: shown.append(logic.message))
    transform, *_ = dragged(scene, logic)
    logic.follow(transform)
    make(scene, logic, transform)
    assert words in logic.message
    assert (shown[0], shown[-1]) == ("", logic.message)
    assert from_parent(transform)([(1.0, 2, 3)]) == pytest.approx(np.array([[1.0, 2, 3]]))


def test_the_file_of_the_window_loads_without_qt():
    import MLSDeform

    assert "qt" not in sys.modules
    assert MLSDeform.installed()
    for name in ("MLSDeform", "MLSDeformLogic", "MLSDeformParameterNode", "MLSDeformWidget"):
        assert isinstance(getattr(MLSDeform, name), type)


def test_each_widget_of_the_window_is_in_its_ui_file():
    code, ui = (
        (MODULE / name).read_text() for name in ("MLSDeform.py", "Resources/UI/MLSDeform.ui")
    )
    used = set(re.findall(r"self\.ui\.(\w+)", code)) | {"addHandle", "addBone", "addCut", "apply"}
    assert used <= set(re.findall(r'name="(\w+)"', ui))
