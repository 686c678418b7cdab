"""Draw docs/mesh.png: `python docs/mesh_picture.py`, with `.[docs,cpu]` installed.

You will see the demo's brain as tetrahedra, cut open by the same control points as its image: as a
volume, with its cells, and a section of mesh and image. TetGen makes the mesh.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import tetgen
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401 - draws volumes
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import (
    VTK_TETRA,
    vtkCellArray,
    vtkPiecewiseFunction,
    vtkPlane,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import (
    vtkCleanPolyData,
    vtkCutter,
    vtkFeatureEdges,
    vtkFlyingEdges3D,
    vtkPolyDataConnectivityFilter,
    vtkPolyDataNormals,
    vtkProbeFilter,
)
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkImagingCore import vtkImageReslice
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkColorTransferFunction,
    vtkImageSlice,
    vtkImageSliceMapper,
    vtkPolyDataMapper,
    vtkVolume,
)
from vtkmodules.vtkRenderingVolume import vtkProjectedTetrahedraMapper

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "demo"))
from demo_drawing import BACKGROUND, fill, render, window
from demo_scene import LIGHTS, TISSUES, VIEW, brain, marked, pulled_open

from vtk_mls.commands import demo

EDGE_LENGTH, LARGEST = 3, 20  # mm of the triangles that TetGen gets, mm^3 of its tetrahedra
SURFACE = 90  # T1 at which the mesh ends
SECTION = 125.0  # x of the section, mm
MIDDLE = (98.0, 118.0, 84.0)  # of the picture
LINES, OUTLINE = (0.25, 0.75, 1.0), (1.0, 0.55, 0.1)
OPACITY = {0: 0.0, 60: 0.0, 130: 0.015, 170: 0.03, 205: 0.25, 255: 0.5}  # by T1


def draw(file):
    """Draw the picture."""
    image = brain()
    image.GetPointData().SetActiveScalars("T1")
    mesh = _tetrahedra(image)
    opened = []
    for data in (mesh, image):
        deform = pulled_open(data)
        deform.SetOutputGrid("fitted")
        deform.Update()
        opened.append(deform.GetOutputDataObject(0))
    for data in opened:
        data.GetPointData().SetActiveScalars("T1")

    panels = window(3, LIGHTS)
    # VTK draws projected tetrahedra right only in the first panel
    fill(panels, 0, "Tetrahedra as a volume", "each side of the cut is closed", _volume(opened[0]))
    fill(
        panels,
        1,
        "Cells are split along the cut",
        f"{opened[0].GetNumberOfCells():,} tetrahedra",
        _surface(opened[0]),
        *marked(demo.control_points()[1]),
    )
    fill(
        panels,
        2,
        "Mesh and image move as one",
        "a section of both, by the same handles",
        *_section(*opened),
    )
    render(panels, VIEW, MIDDLE, 104, file, {2: (1, 0, 0)})


def _tetrahedra(image):
    """What of an image is above SURFACE, as vtkUnstructuredGrid with its scalars."""
    smooth = vtkImageGaussianSmooth()
    smooth.SetInputData(image)
    smooth.SetStandardDeviation(1.5)
    smooth.SetRadiusFactor(3)
    coarse = vtkImageReslice()  # with a margin, so that the surface is closed
    coarse.SetInputConnection(smooth.GetOutputPort())
    coarse.SetInterpolationModeToLinear()
    coarse.SetOutputSpacing(3 * [EDGE_LENGTH])
    coarse.SetOutputOrigin(3 * [-3 * EDGE_LENGTH])
    steps = [n // EDGE_LENGTH + 6 for n in image.GetDimensions()]
    coarse.SetOutputExtent([i for n in steps for i in (0, n)])
    contour = vtkFlyingEdges3D()
    contour.SetInputConnection(coarse.GetOutputPort())
    contour.SetValue(0, SURFACE)
    largest = vtkPolyDataConnectivityFilter()
    largest.SetInputConnection(contour.GetOutputPort())
    largest.SetExtractionModeToLargestRegion()
    clean = vtkCleanPolyData()
    clean.SetInputConnection(largest.GetOutputPort())
    clean.Update()
    surface = clean.GetOutput()
    corners = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    positions = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    mesher = tetgen.TetGen(positions, corners.astype(np.int32))
    # p: within the surface, Y: as it is, q: ratio of radius and edge, a: volume, Q: quietly
    positions, corners, *_ = mesher.tetrahedralize(switches=f"pYq1.5a{LARGEST}Q")

    points, cells, mesh = vtkPoints(), vtkCellArray(), vtkUnstructuredGrid()
    points.SetData(numpy_to_vtk(positions.astype(np.float32), deep=True))
    cells.SetData(4, numpy_to_vtkIdTypeArray(np.ravel(corners).astype(np.int64), deep=True))
    mesh.SetPoints(points)
    mesh.SetCells(VTK_TETRA, cells)
    probe = vtkProbeFilter()
    probe.SetInputData(mesh)
    probe.SetSourceData(image)
    probe.Update()
    mesh.GetPointData().SetScalars(probe.GetOutput().GetPointData().GetArray("T1"))
    return mesh


def _colours():
    colors = vtkColorTransferFunction()
    for t1, color in TISSUES.items():
        colors.AddRGBPoint(t1, *color)
    return colors


def _volume(mesh):
    mapper, volume, opacity = vtkProjectedTetrahedraMapper(), vtkVolume(), vtkPiecewiseFunction()
    mapper.SetInputData(mesh)
    for t1, value in OPACITY.items():
        opacity.AddPoint(t1, value)
    volume.SetMapper(mapper)
    volume.GetProperty().SetScalarOpacity(opacity)
    volume.GetProperty().SetColor(_colours())
    volume.GetProperty().SetScalarOpacityUnitDistance(EDGE_LENGTH)
    volume.GetProperty().SetInterpolationTypeToLinear()
    return volume


def _surface(mesh):
    surface, normals = vtkGeometryFilter(), vtkPolyDataNormals()
    surface.SetInputData(mesh)
    normals.SetInputConnection(surface.GetOutputPort())
    normals.SetFeatureAngle(60)
    actor = _actor(normals)
    actor.GetMapper().SetLookupTable(_colours())
    actor.GetMapper().SetColorModeToMapScalars()
    actor.GetProperty().EdgeVisibilityOn()
    actor.GetProperty().SetEdgeColor(0.2, 0.1, 0.1)
    actor.GetProperty().SetAmbient(0.25)
    return actor


def _section(mesh, image):
    """The image at SECTION, and before it the cells there with their outline."""
    plane, cells, outline = vtkPlane(), vtkCutter(), vtkFeatureEdges()
    plane.SetOrigin(SECTION, 0, 0)
    plane.SetNormal(1, 0, 0)
    cells.SetInputData(mesh)
    cells.SetCutFunction(plane)
    cells.GenerateTrianglesOff()
    outline.SetInputConnection(cells.GetOutputPort())
    outline.FeatureEdgesOff()
    outline.NonManifoldEdgesOff()
    outline.ColoringOff()
    drawn = []
    for source, color, opacity, width in ((cells, LINES, 0.5, 1.5), (outline, OUTLINE, 1, 5)):
        actor = _actor(source)
        actor.GetMapper().ScalarVisibilityOff()
        actor.SetPosition(len(drawn) + 1, 0, 0)
        actor.GetProperty().SetRepresentationToWireframe()
        actor.GetProperty().SetColor(color)
        actor.GetProperty().SetOpacity(opacity)
        actor.GetProperty().SetLineWidth(width)
        actor.GetProperty().LightingOff()
        drawn.append(actor)
    mapper, gray = vtkImageSliceMapper(), vtkImageSlice()
    mapper.SetInputData(image)
    mapper.SetOrientationToX()
    mapper.SetSliceNumber(round(SECTION - image.GetOrigin()[0]))
    gray.SetMapper(mapper)
    shades = vtkColorTransferFunction()
    shades.AddRGBPoint(0, *BACKGROUND)
    shades.AddRGBPoint(230, 1, 1, 1)
    gray.GetProperty().SetLookupTable(shades)
    gray.GetProperty().UseLookupTableScalarRangeOn()
    return gray, *drawn


def _actor(source):
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputConnection(source.GetOutputPort())
    actor.SetMapper(mapper)
    return actor


if __name__ == "__main__":
    draw(Path(__file__).with_name("mesh.png"))
