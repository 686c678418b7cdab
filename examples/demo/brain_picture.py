"""The demo's second part: a brain cut from above and pulled open.

`make_demo.py` runs it as a process of its own, like `frog_picture.py`. It leaves brain.vti, cut.vti
and cut.png in a directory.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from demo_drawing import fill, render, window
from demo_scene import (
    EDGE,
    LIGHTS,
    MIDDLE,
    TISSUES,
    VIEW,
    add,
    brain,
    marked,
    pulled_open,
)
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkFlyingEdges3D
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls.commands import demo

SURFACE = 105  # T1 at which the brain ends, of 255
BRAIN = (0.87, 0.66, 0.60)


def draw(directory: Path):
    """Write brain.vti, cut.vti and cut.png to `directory`."""
    uncut = brain()
    t1 = vtk_to_numpy(uncut.GetPointData().GetArray("T1"))
    _save(uncut, directory / "brain.vti", t1)
    cut = opened(uncut)
    solid = 1 - vtk_to_numpy(cut.GetPointData().GetArray("Void")).astype(np.float32)
    t1 = vtk_to_numpy(cut.GetPointData().GetArray("T1"))
    _save(cut, directory / "cut.vti", solid * t1, ["Void", "VoidDistance"])  # nothing in the void
    outside = clipped(contour(cut, "T1", SURFACE), "VoidDistance", 0.0)
    face = clipped(contour(cut, "VoidDistance", 0.0), "T1", SURFACE)
    whole = contour(uncut, "T1", SURFACE)

    before, after = (marked(positions) for positions in demo.control_points())
    panels = window(3, LIGHTS)
    fill(
        panels,
        0,
        "Before",
        "a half-plane cuts it; orange handles are dragged",
        shaded(whole, "Turned", BRAIN),
        _sheet(),
        *before,
    )
    fill(
        panels,
        1,
        "Pulled open",
        "gradients corrected: light falls on what is there",
        shaded(outside, "Turned", BRAIN),
        shaded(face, "Gradients"),
        *after,
    )
    fill(
        panels,
        2,
        "Without gradient correction",
        "gradients moved but not turned: light as if nothing had",
        shaded(outside, "Carried", BRAIN),
        shaded(face, "Carried"),
        *after,
    )
    render(panels, VIEW, MIDDLE, 97, directory / "cut.png")


def opened(image):
    """The image of the brain, cut and pulled open, with values continued behind the faces."""
    deform = pulled_open(image)
    deform.SetHideVoid(False)  # contours need the cells on the face,
    deform.SetVoidValues("continued")  # and colors behind it
    deform.AddGradientVectorArray("Turned")
    deform.Update()
    image = vtkImageData()
    image.ShallowCopy(deform.GetOutputDataObject(0))
    return image


def _save(image, file, t1, names=()):
    """Write what one may want to look at elsewhere: T1, and some other arrays."""
    part = vtkImageData()
    part.CopyStructure(image)
    for name in names:
        part.GetPointData().AddArray(image.GetPointData().GetArray(name))
    add(part, "T1", t1)
    part.GetPointData().SetActiveScalars("T1")
    writer = vtkXMLImageDataWriter()
    writer.SetInputData(part)
    writer.SetFileName(str(file))
    writer.Write()


def contour(image, name, value):
    """The surface where an array has a value."""
    image.GetPointData().SetActiveScalars(name)
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, value)
    contour.SetInterpolateAttributes(True)
    contour.SetComputeGradients(True)
    contour.Update()
    return contour.GetOutput()


def clipped(surface, name, value):
    """The part where an array is above a value."""
    surface.GetPointData().SetActiveScalars(name)
    clip = vtkClipPolyData()
    clip.SetInputData(surface)
    clip.SetValue(value)
    clip.Update()
    return clip.GetOutput()


def shaded(surface, gradient, color=None):
    """Actor lit by minus a gradient, in one color or those of T1."""
    data = surface.GetPointData()
    slope = vtk_to_numpy(data.GetArray(gradient)).astype(float)
    length = np.linalg.norm(slope, axis=1, keepdims=True)
    normals = numpy_to_vtk((-slope / np.maximum(length, 1e-9)).astype(np.float32), deep=True)
    lit = vtkPolyData()
    lit.SetPoints(surface.GetPoints())
    lit.SetPolys(surface.GetPolys())
    lit.GetPointData().SetNormals(normals)
    if color is None:
        t1 = vtk_to_numpy(data.GetArray("T1"))
        tints = np.array(list(TISSUES.values())).T
        rgb = np.stack([np.interp(t1, list(TISSUES), tint) for tint in tints], axis=-1)
        lit.GetPointData().SetScalars(numpy_to_vtk((255 * rgb).astype(np.uint8), deep=True))
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(lit)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(color or (1, 1, 1))
    actor.GetProperty().SetAmbient(0.1)
    actor.GetProperty().SetDiffuse(0.9)
    actor.GetProperty().SetSpecular(0.15)
    actor.GetProperty().SetSpecularPower(25)
    return actor


def _sheet():
    plane = vtkPlaneSource()
    plane.SetOrigin(18, EDGE[1], EDGE[2])
    plane.SetPoint1(178, EDGE[1], EDGE[2])
    plane.SetPoint2(18, EDGE[1], 156)
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(plane.GetOutputPort())
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.55, 0.85, 1.0)
    actor.GetProperty().SetOpacity(0.5)
    actor.GetProperty().LightingOff()
    return actor


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
