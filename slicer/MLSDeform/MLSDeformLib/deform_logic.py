"""A grid transform node that follows control points, curves, bones and cuts of a scene.

All that a deformation is made of hangs on its grid transform node: references to the nodes, and
attributes for the options. So a scene can have several deformations, and saves them whole. Nothing
here needs Qt, or a window.

Positions are in the frame of the transform's parent, which is the world (RAS) without one. A node
under the transform itself counts where it is before the deformation.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from typing import Any

import numpy as np
import slicer
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import vtk_mls
from vtk_mls import landmarks
from vtk_mls.model.options import named

# Roles of references. The n-th node of _REST belongs to the n-th of _MOVED.
_DATA, _REST, _MOVED = "MLSDeform.data", "MLSDeform.rest", "MLSDeform.moved"
_BONE, _CUT = "MLSDeform.bone", "MLSDeform.cut"
# Options, as arguments of `vtk_mls.Deformation`, and their values in a new deformation.
OPTIONS = {name: named(name).default for name in ("kind", "alpha", "smoothing", "steps")}
KINDS = ("rigid", "similarity", "affine", "spline", "auto")
# Points of the grid along its longest edge: while the mouse moves, and at its release.
COARSE, FINE = 64, 128
# The grid is larger than the data by this share of its longest edge on each side.
_MARGIN = 0.1
# Of Slicer's iterated inverse, in spacings of the grid.
_INVERSE_TOLERANCE = 1e-4

_CURVES = (slicer.vtkMRMLMarkupsCurveNode,)
_POINT_EVENTS = (
    slicer.vtkMRMLMarkupsNode.PointModifiedEvent,
    slicer.vtkMRMLMarkupsNode.PointAddedEvent,
    slicer.vtkMRMLMarkupsNode.PointRemovedEvent,
)


class DeformLogic:
    """Makes deformations in a scene, and keeps one of them up to date.

    Parameters
    ----------
    scene : vtkMRMLScene
    on_update : callable
        Called after each update, when `message` says what did not fit.
    """

    def __init__(self, scene, on_update=lambda: None) -> None:
        self.scene, self._on_update = scene, on_update
        self.message = ""  # of the last update, if it failed
        self._followed = None
        self._observed: list[tuple[Any, Any]] = []
        self._is_dragging = False

    # The parts of a deformation

    def create(self, data, name: str = "MLS Deform"):
        """A new vtkMRMLGridTransformNode for `data`: a volume, a model or a segmentation."""
        node = self.scene.AddNewNodeByClass("vtkMRMLGridTransformNode", name)
        node.SetNodeReferenceID(_DATA, data.GetID())
        return node

    def add_handle(self, transform, rest, moved=None):
        """Add control points or a curve at rest, and where they are moved to.

        Parameters
        ----------
        transform : vtkMRMLGridTransformNode
        rest, moved : vtkMRMLMarkupsFiducialNode or vtkMRMLMarkupsCurveNode
            Of the same number of points. By default `moved` is a new copy of `rest`, and `rest` is
            locked.

        Returns
        -------
        vtkMRMLMarkupsNode
            `moved`.
        """
        if moved is None:
            moved = self.scene.AddNewNodeByClass(rest.GetClassName(), f"{rest.GetName()} moved")
            for i in range(rest.GetNumberOfControlPoints()):
                place = rest.GetNthControlPointPositionWorld(i)
                moved.AddControlPointWorld(vtk.vtkVector3d(*place), rest.GetNthControlPointLabel(i))
            if rest.IsA("vtkMRMLMarkupsCurveNode"):
                moved.SetCurveType(rest.GetCurveType())
            rest.SetLocked(True)
        transform.AddNodeReferenceID(_REST, rest.GetID())
        transform.AddNodeReferenceID(_MOVED, moved.GetID())
        return self._changed(transform, moved)

    def add_bone(self, transform, bone):
        """Add a model, or each segment of a segmentation, as a rigid region.

        Its motion is its own transform: the rigid transform node that it is under.
        """
        transform.AddNodeReferenceID(_BONE, bone.GetID())
        return self._changed(transform, bone)

    def add_cut(self, transform, plane):
        """Add a vtkMRMLMarkupsPlaneNode as a cut through the material at rest."""
        transform.AddNodeReferenceID(_CUT, plane.GetID())
        return self._changed(transform, plane)

    def remove(self, transform, node) -> None:
        """Remove a handle (by either of its nodes), a bone, a cut or the data."""
        for i, pair in reversed([*enumerate(self.handles(transform))]):
            if node in pair:
                transform.RemoveNthNodeReferenceID(_REST, i)
                transform.RemoveNthNodeReferenceID(_MOVED, i)
        for role in (_BONE, _CUT, _DATA):
            for i in reversed(range(transform.GetNumberOfNodeReferences(role))):
                if transform.GetNthNodeReference(role, i) is node:
                    transform.RemoveNthNodeReferenceID(role, i)
        self._changed(transform, node)

    def handles(self, transform) -> list[tuple[Any, Any]]:
        """The pairs (rest, moved) of markups nodes."""
        return [*zip(_references(transform, _REST), _references(transform, _MOVED))]

    def bones(self, transform) -> list[Any]:
        """The models and segmentations that are rigid regions."""
        return _references(transform, _BONE)

    def cuts(self, transform) -> list[Any]:
        """The plane nodes that are cuts."""
        return _references(transform, _CUT)

    def data(self, transform):
        """The node whose box the grid covers, or None."""
        return transform.GetNodeReference(_DATA)

    def options(self, transform) -> dict[str, Any]:
        """The options by name; see `OPTIONS`."""
        return {name: _value(transform, name, usual) for name, usual in OPTIONS.items()}

    def set_options(self, transform, **values) -> None:
        """Set some of the `OPTIONS`; `steps` 0 takes as many as are needed to prevent folds."""
        for name, value in values.items():
            if name not in OPTIONS:
                raise ValueError(f"`{name}` must be one of {', '.join(OPTIONS)}")
            transform.SetAttribute(f"MLSDeform.{name}", str(value))
        self._changed(transform, None)

    # What it is computed from

    def deformation(self, transform) -> vtk_mls.Deformation:
        """The deformation in the frame of the transform's parent.

        Raises
        ------
        ValueError
            One sentence, where inputs do not fit.
        """
        rest, moved, curves = [np.empty((0, 3))], [np.empty((0, 3))], []
        for pair in self.handles(transform):
            p, q = (_places(transform, node) for node in pair)
            if len(p) != len(q):
                raise ValueError(
                    f'"{pair[0].GetName()}" has {pair[0].GetNumberOfControlPoints()} points and '
                    f'"{pair[1].GetName()}" {pair[1].GetNumberOfControlPoints()}; '
                    "they need the same number"
                )
            if isinstance(pair[0], _CURVES):
                curves.append(vtk_mls.CurveHandle(p, q))
            else:
                rest.append(p)
                moved.append(q)
        options = self.options(transform)
        return vtk_mls.Deformation(
            np.concatenate(rest),
            np.concatenate(moved),
            **{**options, "steps": options["steps"] or "auto"},
            handles=[
                *curves,
                *(r for bone in self.bones(transform) for r in _regions(transform, bone)),
            ],
            cuts=[_cut(transform, plane) for plane in self.cuts(transform)],
        )

    def grid(self, transform, longest: int = FINE) -> vtk_mls.Grid:
        """A grid around the data, with `longest` points along its longest edge."""
        data = self.data(transform)
        if data is None:
            raise ValueError("the deformation needs a volume, a model or a segmentation")
        bounds = [0.0] * 6
        data.GetBounds(bounds)
        if bounds[0] > bounds[1]:
            raise ValueError(f'"{data.GetName()}" is empty')
        corners = np.stack(np.meshgrid(*np.reshape(bounds, (3, 2))), axis=-1).reshape(-1, 3)
        corners = _moved(_to_frame(transform, data.GetParentTransformNode()), corners)
        low, high = corners.min(axis=0), corners.max(axis=0)
        margin = _MARGIN * (high - low).max()
        spacing = ((high - low).max() + 2 * margin) / (longest - 1)
        dimensions = np.ceil((high - low + 2 * margin) / spacing - 1e-9).astype(int) + 1
        return vtk_mls.Grid(dimensions, low - margin, (spacing,) * 3)

    # Updates

    def update(self, transform, longest: int = FINE) -> bool:
        """Compute the transform; if it cannot be, `message` says why, and it does nothing.

        Its map from the parent is `backward` of the deformation. Slicer inverts it by iteration.
        """
        self.message = ""
        try:
            result = self._grid_transform(transform, longest)
        except (ValueError, TypeError, vtk_mls.DeviceError) as error:
            self.message, result = str(error), slicer.vtkOrientedGridTransform()
        transform.SetAndObserveTransformFromParent(result)
        self._on_update()
        return not self.message

    def _grid_transform(self, transform, longest):
        deformation, grid = self.deformation(transform), self.grid(transform, longest)
        displacement = deformation.displacement_field(grid).displacement
        image = vtk.vtkImageData()
        image.SetDimensions(*map(int, grid.dimensions))
        image.SetOrigin(*grid.origin)
        image.SetSpacing(*grid.spacing)
        image.GetPointData().SetScalars(numpy_to_vtk(displacement.reshape(-1, 3), deep=True))
        result = slicer.vtkOrientedGridTransform()
        result.SetDisplacementGridData(image)
        result.SetInterpolationModeToCubic()
        result.SetInverseTolerance(_INVERSE_TOLERANCE * grid.spacing[0])
        return result

    def report(self, transform, table) -> landmarks.Report:
        """Write to a vtkMRMLTableNode how well each pair of points follows from the others."""
        pairs = [pair for pair in self.handles(transform) if not isinstance(pair[0], _CURVES)]
        names, places = [], ([np.empty((0, 3))], [np.empty((0, 3))])
        for pair in pairs:
            count = pair[0].GetNumberOfControlPoints()
            names += [pair[0].GetNthControlPointLabel(i) for i in range(count)]
            for side, node in zip(places, pair):
                side.append(_places(transform, node))
        rest, moved = map(np.concatenate, places)
        report = landmarks.report(rest, moved, names)
        table.RemoveAllColumns()
        for title, values in (
            ("landmark", names),
            ("error left out (mm)", [f"{error:.2f}" for error in report.error]),
            ("outlier", ["yes" if outlier else "" for outlier in report.outlier]),
        ):
            column = vtk.vtkStringArray()
            column.SetName(title)
            for value in values:
                column.InsertNextValue(value)
            table.AddColumn(column)
        return report

    # Live

    def follow(self, transform) -> None:
        """Update a transform whenever one of its parts moves, and no other any more.

        While a point is dragged the grid is coarse; it is fine at its release.
        """
        self.unfollow()
        if transform is None:
            return
        self._followed = transform
        self._observe(self.scene, self.scene.NodeAboutToBeRemovedEvent, self._on_removed)
        self._observe(self.scene, self.scene.StartCloseEvent, self._on_close)
        for pair in self.handles(transform):
            for node in pair:
                for event in _POINT_EVENTS:
                    self._observe(node, event, self._on_moved)
                self._observe(node, node.PointStartInteractionEvent, self._on_press)
                self._observe(node, node.PointEndInteractionEvent, self._on_release)
        for node in (*self.bones(transform), self.data(transform)):
            if node is not None:
                event = slicer.vtkMRMLTransformableNode.TransformModifiedEvent
                self._observe(node, event, self._on_moved)
        for node in self.cuts(transform):
            self._observe(node, vtk.vtkCommand.ModifiedEvent, self._on_moved)
        self.update(transform)

    def unfollow(self) -> None:
        """Leave the transform as it is, and no observer behind."""
        for node, tag in self._observed:
            node.RemoveObserver(tag)
        self._observed, self._followed, self._is_dragging = [], None, False

    def _observe(self, node, event, method) -> None:
        weak = weakref.WeakMethod(method)  # nodes do not keep this object alive

        def call(*arguments):
            if (alive := weak()) is not None:
                alive(*arguments)

        if hasattr(method, "CallDataType"):
            vtk.calldata_type(method.CallDataType)(call)
        self._observed.append((node, node.AddObserver(event, call)))

    def _changed(self, transform, result):
        if transform is self._followed:
            self.follow(transform)
        return result

    def _on_press(self, *_) -> None:
        self._is_dragging = True

    def _on_release(self, *_) -> None:
        self._is_dragging = False
        self.update(self._followed)

    def _on_moved(self, node, _) -> None:
        # The transform moves its own data, and tells the data so.
        if not (node is self.data(self._followed) and _is_under(node, self._followed)):
            self.update(self._followed, COARSE if self._is_dragging else FINE)

    @vtk.calldata_type(vtk.VTK_OBJECT)
    def _on_removed(self, _, event, node) -> None:
        followed = self._followed
        if node is followed:
            self.unfollow()
        elif any(node is observed for observed, _ in self._observed):
            self.remove(followed, node)

    def _on_close(self, *_) -> None:
        self.unfollow()


def _references(transform, role) -> list[Any]:
    count = transform.GetNumberOfNodeReferences(role)
    return [transform.GetNthNodeReference(role, i) for i in range(count)]


def _value(transform, name, usual):
    text = transform.GetAttribute(f"MLSDeform.{name}")
    return usual if text is None else type(usual)(text)


def _ancestors(node) -> Iterator[Any]:
    parent = node.GetParentTransformNode()
    while parent is not None:
        yield parent
        parent = parent.GetParentTransformNode()


def _is_under(node, transform) -> bool:
    return any(parent is transform for parent in _ancestors(node))


def _to_frame(transform, parent) -> vtk.vtkGeneralTransform:
    """From the children of the transform node `parent` (None: the world) to the frame."""
    below = parent is not None and (parent is transform or _is_under(parent, transform))
    target = transform if below else transform.GetParentTransformNode()
    result = vtk.vtkGeneralTransform()
    slicer.vtkMRMLTransformNode.GetTransformBetweenNodes(parent, target, result)
    return result


def _moved(general, points):
    """Points (n, 3) after a vtkAbstractTransform."""
    before, after = vtk.vtkPoints(), vtk.vtkPoints()
    before.SetData(numpy_to_vtk(np.array(points, np.float64).reshape(-1, 3), deep=True))
    after.SetDataTypeToDouble()
    general.TransformPoints(before, after)
    return vtk_to_numpy(after.GetData()).copy()


def _places(transform, node):
    """Nodes of a curve, or control points, (n, 3) in the frame."""
    if isinstance(node, _CURVES):
        points = node.GetCurvePoints()
        local = [points.GetPoint(i) for i in range(points.GetNumberOfPoints() if points else 0)]
    else:
        count = node.GetNumberOfControlPoints()
        local = [node.GetNthControlPointPosition(i) for i in range(count)]
    return _moved(_to_frame(transform, node.GetParentTransformNode()), local)


def _rigid(general, what):
    """The matrix (4, 4) of a vtkGeneralTransform that is affine."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    moved = _moved(general, corners)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = (moved[1:] - moved[0]).T, moved[0]
    check = np.array([[300.0, -200, 100]])
    expected = check @ matrix[:3, :3].T + matrix[:3, 3]
    if not np.allclose(_moved(general, check), expected, atol=1e-6):
        raise ValueError(f"{what} must be under a linear transform, not one that bends")
    return matrix


def _regions(transform, bone) -> list[Any]:
    """The rigid regions of a model or a segmentation, moved by the transform that it is under."""
    if _is_under(bone, transform):
        raise ValueError(f'"{bone.GetName()}" must not be under the transform that it moves')
    motion = bone.GetParentTransformNode()
    base = _to_frame(transform, motion.GetParentTransformNode() if motion else None)
    # Frame at rest -> the bone's own coordinates -> where its transform takes it
    way = vtk.vtkGeneralTransform()
    way.Concatenate(_to_frame(transform, motion))
    way.Concatenate(base.GetInverse())
    matrix = _rigid(way, f'"{bone.GetName()}"')
    return [
        vtk_mls.RegionHandle(vtk_mls.Solid(_moved(base, points), triangles), matrix)
        for points, triangles in map(_triangles, _surfaces(bone))
    ]


def _surfaces(bone) -> list[Any]:
    if bone.IsA("vtkMRMLModelNode"):
        return [bone.GetPolyData()]
    bone.CreateClosedSurfaceRepresentation()
    segmentation, surfaces = bone.GetSegmentation(), []
    for name in segmentation.GetSegmentIDs():
        surface = vtk.vtkPolyData()
        bone.GetClosedSurfaceRepresentation(name, surface)
        surfaces.append(surface)
    return surfaces


def _triangles(surface):
    """Points (n, 3) and triangles (m, 3) of a vtkPolyData."""
    triangulation = vtk.vtkTriangleFilter()
    triangulation.SetInputData(surface)
    triangulation.PassVertsOff()
    triangulation.PassLinesOff()
    triangulation.Update()
    output = triangulation.GetOutput()
    triangles = vtk_to_numpy(output.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return vtk_to_numpy(output.GetPoints().GetData()).astype(float), triangles


def _cut(transform, plane) -> vtk_mls.Plane:
    """The plane of a markup in the frame."""
    center, normal = np.zeros(3), np.zeros(3)
    plane.GetCenter(center)
    plane.GetNormal(normal)
    way = _to_frame(transform, plane.GetParentTransformNode())
    matrix = _rigid(way, f'"{plane.GetName()}"')
    normal = np.linalg.inv(matrix[:3, :3]).T @ normal
    return vtk_mls.Plane(_moved(way, center)[0], normal)
