"""The picture of the demo, drawn from its files: the original and the four kinds side by side.

`make_demo.py` runs it as a process of its own: without a working OpenGL the process may crash.
"""

from __future__ import annotations

import sys
from pathlib import Path

import demo_drawing as drawing
import numpy as np
from demo_drawing import BACKGROUND, DRAGGED, PINNED, REST, actor_of, blank, spheres, text
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import (
    vtkPolyDataNormals,
    vtkSurfaceNets3D,
    vtkTubeFilter,
)
from vtkmodules.vtkFiltersSources import vtkConeSource, vtkLineSource
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPolyDataReader
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
)
from vtkmodules.vtkRenderingOpenGL2 import vtkRenderStepsPass, vtkSSAOPass

PANELS = {
    "original": "orange handles are dragged, blue ones stay",
    "affine": "turns, stretches and shears",
    "similarity": "turns and scales",
    "rigid": "only turns: bones keep their size",
    "polynomial": "also bends (degree 2)",
}
PANEL = (480, 640)  # pixels
TISSUES = {
    1: (0.80, 0.16, 0.16),  # blood
    2: (0.93, 0.68, 0.60),  # brain
    3: (0.88, 0.62, 0.38),  # duodenum
    4: (0.10, 0.14, 0.20),  # retina
    5: (0.92, 0.94, 0.96),  # white of the eye
    6: (0.85, 0.12, 0.18),  # heart
    7: (0.86, 0.52, 0.42),  # ileum
    8: (0.62, 0.30, 0.24),  # kidney
    9: (0.80, 0.54, 0.48),  # large intestine
    10: (0.60, 0.26, 0.18),  # liver
    11: (0.92, 0.58, 0.62),  # lung
    12: (0.98, 0.80, 0.28),  # nerve
    13: (0.95, 0.91, 0.80),  # skeleton
    14: (0.56, 0.20, 0.36),  # spleen
    15: (0.86, 0.70, 0.50),  # stomach
}


def draw(directory: Path) -> Path:
    """Write `directory`/demo.png from the .vti files and the control points there."""
    rest, deformed = _control_points(directory / "handles.vtp")
    window = blank(PANEL[0] * len(PANELS), PANEL[1])
    window.SetNumberOfLayers(2)
    for i, (name, caption) in enumerate(PANELS.items()):
        viewport = (i / len(PANELS), 0, (i + 1) / len(PANELS), 1)
        scene, overlay = vtkRenderer(), vtkRenderer()
        scene.SetBackground(BACKGROUND)
        scene.SetPass(_ambient_occlusion())
        overlay.SetLayer(1)
        scene.AddActor(_tissues(directory / f"{name}.vti"))
        for actor in _drag(rest, deformed, at_rest=name == "original"):
            overlay.AddActor(actor)
        overlay.AddViewProp(text(name.capitalize(), 0.93, 30, bold=True))
        overlay.AddViewProp(text(caption, 0.875, 19, bold=False))
        for renderer in (scene, overlay):
            renderer.SetViewport(viewport)
            _look_from_above(renderer.GetActiveCamera())
            window.AddRenderer(renderer)
            renderer.ResetCameraClippingRange()
    picture = directory / "demo.png"
    drawing.draw(window, picture)
    return picture


def _control_points(file):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    polydata = reader.GetOutput()
    rest = vtk_to_numpy(polydata.GetPoints().GetData())
    return rest, rest + vtk_to_numpy(polydata.GetPointData().GetArray("Displacement"))


def _tissues(file):
    """Actor of the outer surface of all tissues, one color each."""
    reader = vtkXMLImageDataReader()
    reader.SetFileName(str(file))
    nets = vtkSurfaceNets3D()
    nets.SetInputConnection(reader.GetOutputPort())
    for i, label in enumerate(TISSUES):
        nets.SetValue(i, label)
    nets.SetBackgroundLabel(0)
    nets.SetNumberOfIterations(16)
    nets.SetOutputMeshTypeToTriangles()
    nets.Update()

    normals = vtkPolyDataNormals()
    normals.SetInputData(_outer(nets.GetOutput()))
    normals.SplittingOff()
    normals.ConsistencyOff()
    colors = vtkLookupTable()
    colors.SetNumberOfTableValues(len(TISSUES))
    colors.SetRange(min(TISSUES), max(TISSUES))
    for i, color in enumerate(TISSUES.values()):
        colors.SetTableValue(i, *color, 1.0)
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort())
    mapper.SetColorModeToMapScalars()
    mapper.SetLookupTable(colors)
    mapper.UseLookupTableScalarRangeOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetAmbient(0.12)
    actor.GetProperty().SetDiffuse(0.9)
    actor.GetProperty().SetSpecular(0.18)
    actor.GetProperty().SetSpecularPower(30)
    return actor


def _outer(mesh):
    """The triangles between a tissue and the background, with the tissue as cell scalars."""
    labels = vtk_to_numpy(mesh.GetCellData().GetArray("BoundaryLabels"))
    triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    outer = labels[:, 1] == 0
    cells = vtkCellArray()
    corners = triangles[outer].ravel().astype(np.int64)
    offsets = np.arange(0, len(corners) + 1, 3, dtype=np.int64)
    cells.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(corners, deep=True)
    )
    surface = vtkPolyData()
    surface.SetPoints(mesh.GetPoints())
    surface.SetPolys(cells)
    surface.GetCellData().SetScalars(numpy_to_vtk(labels[outer, 0].copy(), deep=True))
    return surface


def _drag(rest, deformed, at_rest):
    """Actors of the control points: where they were, where they are, and an arrow between."""
    moved = np.any(deformed != rest, axis=1)
    yield spheres(rest[~moved], 7.0, PINNED)
    if at_rest:
        yield spheres(rest[moved], 7.0, DRAGGED)
    else:
        yield spheres(rest[moved], 4.0, REST)
        yield spheres(deformed[moved], 7.0, DRAGGED)
    for start, end in zip(rest[moved], deformed[moved]):
        yield from _arrow(start, end, DRAGGED if at_rest else REST)


def _arrow(start, end, color):
    """A shaft and a head that ends at the surface of the control point's sphere."""
    along = (end - start) / np.linalg.norm(end - start)
    tip = end - 7.0 * along
    neck = tip - 14.0 * along
    line = vtkLineSource()
    line.SetPoint1(start)
    line.SetPoint2(neck)
    shaft = vtkTubeFilter()
    shaft.SetInputConnection(line.GetOutputPort())
    shaft.SetRadius(1.6)
    shaft.SetNumberOfSides(16)
    head = vtkConeSource()
    head.SetDirection(along)
    head.SetCenter((tip + neck) / 2)
    head.SetHeight(14.0)
    head.SetRadius(6.0)
    head.SetResolution(24)
    return actor_of(shaft, color), actor_of(head, color)


def _ambient_occlusion():
    """Darkens what lies deep between other parts."""
    occlusion = vtkSSAOPass()
    occlusion.SetRadius(25.0)
    occlusion.SetBias(1.0)
    occlusion.SetKernelSize(64)
    occlusion.BlurOn()
    occlusion.SetDelegatePass(vtkRenderStepsPass())
    return occlusion


def _look_from_above(camera):
    """The back of the frog, its head (+x) up."""
    camera.ParallelProjectionOn()
    camera.SetParallelScale(360)
    camera.SetFocalPoint(285, 235, 100)
    camera.SetPosition(285, 235, -1400)
    camera.SetViewUp(1, 0, 0)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
