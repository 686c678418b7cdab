"""The demo's second part: a brain cut from above and pulled open, and the face of the cut close up.

Run as `python -m vtk_mls.demo_cut DIRECTORY`, a process of its own like `demo_picture`. It leaves
cut.vti, cut.png and void.png in the directory.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkFlyingEdges3D
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth, vtkImageGradient
from vtkmodules.vtkIOImage import vtkNIFTIImageReader
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkLight,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
)

from vtk_mls import HalfPlane, demo_volumes
from vtk_mls.demo_picture import BACKGROUND, DRAGGED, OVERSAMPLING, PINNED, spheres, text, write
from vtk_mls.filters import MLSControlPoints, MLSDeform

# In millimetres: x to the right, y to the front, z up. The cut runs down to its edge at EDGE.
EDGE = np.array([98.0, 118.0, 58.0])
CUT = HalfPlane(EDGE, normal=(0, 1, 0), inward=(0, 0, 1))
ANGLE = np.radians(35)  # by which each half is turned about the edge
FRONT = [(157, 125, 115), (112, 125, 149), (159, 146, 102), (150, 175, 88), (125, 177, 117)]
BACK = [(157, 111, 116), (117, 111, 150), (165, 88, 103), (152, 59, 88), (127, 54, 120)]
BELOW = [(157, 142, 53), (163, 86, 51), (113, 114, 36), (135, 52, 25), (127, 171, 51)]
LOWER, UPPER = np.array([15.0, -30.0, 0.0]), np.array([181.0, 262.0, 176.0])  # of the output

SURFACE = 105  # T1 at which the brain ends, of 255
BRAIN = (0.87, 0.66, 0.60)
MIDDLE = (98.0, 118.0, 93.0)  # of the picture
VIEW = (1.0, 0.2, 1.1)  # from the middle towards the eye
LIGHTS = {(0.0, 0.6, 0.8): 1.0, (0.8, -0.6, 0.15): 0.42}  # directions and intensities
CLOSE, CLOSE_VIEW = (141.0, 90.0, 125.0), (1.0, 0.55, 0.6)  # of the picture of the face
CLOSE_LIGHTS = {(0.9, 0.38, 0.34): 1.05, (0.0, 0.8, 0.6): 0.18}
TITLES = 0.86  # from here up, as a part of the height
WIDTH, HEIGHT = 2400, 740  # pixels
TISSUES = {0: (0.25, 0.06, 0.07), 70: (0.4, 0.11, 0.11), 135: (0.72, 0.42, 0.38)} | {
    175: (0.86, 0.62, 0.55),
    205: (0.98, 0.93, 0.86),
    255: (1.0, 0.97, 0.92),
}


def draw(directory: Path):
    """Write cut.vti, cut.png and void.png to `directory`."""
    brain = _brain()
    front, back, below = (_both_sides(points) for points in (FRONT, BACK, BELOW))
    rest = np.vstack([front, back, below])
    deformed = np.vstack([_turned(front, -ANGLE), _turned(back, ANGLE), below])
    cut = _deformed(brain, rest, deformed, directory / "cut.vti")
    outside = _clipped(_contour(cut, "T1", SURFACE), "VoidDistance", 0.0)
    face = _clipped(_contour(cut, "VoidDistance", 0.0), "T1", SURFACE)
    stepped = _clipped(_contour(cut, "Solid", 0.5), "T1", SURFACE)
    whole = _contour(brain, "T1", SURFACE)

    moved = np.any(rest != deformed, axis=1)
    before = spheres(rest[moved], 3.0, DRAGGED), spheres(rest[~moved], 3.0, PINNED)
    after = spheres(deformed[moved], 3.0, DRAGGED), spheres(deformed[~moved], 3.0, PINNED)
    window = _window(3, LIGHTS)
    _fill(
        window,
        0,
        "Before",
        "a half-plane cuts it; orange handles are dragged",
        _shaded(whole, "Turned", BRAIN),
        _sheet(),
        *before,
    )
    _fill(
        window,
        1,
        "Pulled open",
        "gradients corrected: light falls on what is there",
        _shaded(outside, "Turned", BRAIN),
        _shaded(face, "Gradients"),
        *after,
    )
    _fill(
        window,
        2,
        "Without gradient correction",
        "gradients moved but not turned: light as if nothing had",
        _shaded(outside, "Carried", BRAIN),
        _shaded(face, "Carried"),
        *after,
    )
    _draw(window, VIEW, MIDDLE, 97, directory / "cut.png")

    window = _window(2, CLOSE_LIGHTS)
    for i, (surface, title, caption) in enumerate(
        [
            (stepped, "Void, 0 or 1", "contour at one half: steps of voxels"),
            (face, "VoidDistance", "contour at zero: the face of the cut"),
        ]
    ):
        _fill(
            window,
            i,
            title,
            caption,
            _shaded(surface, "Gradients"),
            _shaded(outside, "Turned", BRAIN),
        )
    _draw(window, CLOSE_VIEW, CLOSE, 21, directory / "void.png")


def _brain():
    """T1-weighted volume of a brain, smoothed a little, with its gradient twice."""
    reader = vtkNIFTIImageReader()
    reader.SetFileName(str(demo_volumes.brain()))
    smooth = vtkImageGaussianSmooth()
    smooth.SetInputConnection(reader.GetOutputPort())
    smooth.SetStandardDeviation(0.8)
    gradient = vtkImageGradient()
    gradient.SetInputConnection(smooth.GetOutputPort())
    gradient.SetDimensionality(3)
    gradient.Update()
    brain = vtkImageData()
    brain.DeepCopy(smooth.GetOutput())
    brain.GetPointData().GetScalars().SetName("T1")
    for name in ("Turned", "Carried"):
        values = vtk_to_numpy(gradient.GetOutput().GetPointData().GetScalars())
        _add(brain, name, values.astype(np.float32))
    return brain


def _both_sides(points):
    """The points and their mirror images."""
    points = np.array(points, dtype=float)
    return np.vstack([points, points * (-1, 1, 1) + (2 * EDGE[0], 0, 0)])


def _turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return EDGE + (points - EDGE) @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


def _deformed(brain, rest, deformed, file):
    handles = MLSControlPoints()
    handles.SetRestPoints(rest.tolist())
    handles.SetDeformedPoints(deformed.tolist())
    deform = MLSDeform()
    deform.SetInputData(brain)
    deform.SetInputConnection(1, handles.GetOutputPort())
    deform.AddCut(CUT)
    deform.SetHideVoid(False)  # contours need the cells on the face,
    deform.SetVoidValues("continued")  # and colours behind it
    deform.AddGradientVectorArray("Turned")
    deform.SetOutputGrid("given")
    deform.SetOutputOrigin(*LOWER)
    deform.SetOutputDimensions(*(UPPER - LOWER + 1).astype(int).tolist())
    deform.Update()
    image = vtkImageData()
    image.ShallowCopy(deform.GetOutputDataObject(0))
    solid = 1 - vtk_to_numpy(image.GetPointData().GetArray("Void")).astype(np.float32)
    _add(image, "Solid", solid)
    _save(image, file, solid)
    return image


def _add(image, name, values):
    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    image.GetPointData().AddArray(array)


def _save(image, file, solid):
    """Write what one may want to look at elsewhere, with nothing in the void."""
    part = vtkImageData()
    part.CopyStructure(image)
    for name in ("Void", "VoidDistance"):
        part.GetPointData().AddArray(image.GetPointData().GetArray(name))
    _add(part, "T1", solid * vtk_to_numpy(image.GetPointData().GetArray("T1")))
    part.GetPointData().SetActiveScalars("T1")
    writer = vtkXMLImageDataWriter()
    writer.SetInputData(part)
    writer.SetFileName(str(file))
    writer.Write()


def _contour(image, name, value):
    image.GetPointData().SetActiveScalars(name)
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, value)
    contour.SetInterpolateAttributes(True)
    contour.SetComputeGradients(True)
    contour.Update()
    return contour.GetOutput()


def _clipped(surface, name, value):
    """The part where an array is above a value."""
    surface.GetPointData().SetActiveScalars(name)
    clip = vtkClipPolyData()
    clip.SetInputData(surface)
    clip.SetValue(value)
    clip.Update()
    return clip.GetOutput()


def _shaded(surface, gradient, colour=None):
    """Actor lit by minus a gradient, in one colour or those of T1."""
    data = surface.GetPointData()
    slope = vtk_to_numpy(data.GetArray(gradient)).astype(float)
    length = np.linalg.norm(slope, axis=1, keepdims=True)
    normals = numpy_to_vtk((-slope / np.maximum(length, 1e-9)).astype(np.float32), deep=True)
    lit = vtkPolyData()
    lit.SetPoints(surface.GetPoints())
    lit.SetPolys(surface.GetPolys())
    lit.GetPointData().SetNormals(normals)
    if colour is None:
        t1 = vtk_to_numpy(data.GetArray("T1"))
        tints = np.array(list(TISSUES.values())).T
        rgb = np.stack([np.interp(t1, list(TISSUES), tint) for tint in tints], axis=-1)
        lit.GetPointData().SetScalars(numpy_to_vtk((255 * rgb).astype(np.uint8), deep=True))
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(lit)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(colour or (1, 1, 1))
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


def _window(panels, lights):
    """A window side by side for that many renderers."""
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(OVERSAMPLING * WIDTH, OVERSAMPLING * HEIGHT)
    for i in range(panels):
        scene = vtkRenderer()
        scene.SetViewport(i / panels, 0, (i + 1) / panels, TITLES)
        scene.SetBackground(BACKGROUND)
        scene.AutomaticLightCreationOff()
        for towards, intensity in lights.items():
            light = vtkLight()
            light.SetLightTypeToSceneLight()
            light.SetPosition(towards)
            light.SetIntensity(intensity)
            scene.AddLight(light)
        window.AddRenderer(scene)
    return window


def _fill(window, i, title, caption, *actors):
    scene = window.GetRenderers().GetItemAsObject(i)
    left, _, right, _ = scene.GetViewport()
    titles = vtkRenderer()
    titles.SetViewport(left, TITLES, right, 1)
    titles.SetBackground(BACKGROUND)
    titles.AddViewProp(text(title, 0.55, 34, bold=True))
    titles.AddViewProp(text(caption, 0.15, 23, bold=False))
    window.AddRenderer(titles)
    for actor in actors:
        scene.AddActor(actor)


def _draw(window, view, middle, scale, file):
    for scene in window.GetRenderers():
        camera = scene.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetParallelScale(scale)
        camera.SetFocalPoint(middle)
        camera.SetPosition(np.array(middle) + 600 * np.array(view))
        camera.SetViewUp(0, 0, 1)
        scene.ResetCameraClippingRange()
    window.Render()
    if not window.SupportsOpenGL():
        raise SystemExit("VTK found no OpenGL that it can draw with")
    write(window, file)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
