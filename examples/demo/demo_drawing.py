"""What all pictures of the demo are drawn with."""

from __future__ import annotations

import numpy as np
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  draws, and FreeType texts
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkGlyph3D
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkImagingCore import vtkImageShrink3D
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkLight,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTextActor,
    vtkWindowToImageFilter,
)

TITLES = 0.86  # from here up, as a part of the height
WIDTH, HEIGHT = 2400, 740  # pixels
OVERSAMPLING = 2
BACKGROUND = (0.07, 0.09, 0.13)
DRAGGED, PINNED, REST = (1.0, 0.55, 0.10), (0.25, 0.62, 1.0), (0.62, 0.66, 0.72)


def spheres(centers, radius, color):
    """An actor of balls around points (n, 3)."""
    points = vtkPoints()
    points.SetData(numpy_to_vtk(centers, deep=True))
    balls = vtkPolyData()
    balls.SetPoints(points)
    sphere = vtkSphereSource()
    sphere.SetRadius(radius)
    sphere.SetThetaResolution(24)
    sphere.SetPhiResolution(24)
    glyphs = vtkGlyph3D()
    glyphs.SetInputData(balls)
    glyphs.SetSourceConnection(sphere.GetOutputPort())
    return actor_of(glyphs, color)


def actor_of(source, color):
    """The actor of an algorithm's output, in one color."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(color)
    actor.GetProperty().SetAmbient(0.35)
    actor.GetProperty().SetDiffuse(0.65)
    return actor


def text(text, height, size, bold):
    """A line at a height of a panel, in the middle."""
    actor = vtkTextActor()
    actor.SetInput(text)
    actor.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    actor.SetPosition(0.5, height)
    font = actor.GetTextProperty()
    font.SetFontFamilyToArial()
    font.SetFontSize(size * OVERSAMPLING)
    font.SetBold(bold)
    font.SetColor((1.0, 1.0, 1.0) if bold else (0.72, 0.77, 0.84))
    font.SetJustificationToCentered()
    return actor


def blank(width, height):
    """A window that is not shown."""
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(OVERSAMPLING * width, OVERSAMPLING * height)
    return window


def draw(window, file):
    """Write the picture of a window."""
    window.Render()
    if not window.SupportsOpenGL():
        raise SystemExit("VTK found no OpenGL that it can draw with")
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    smooth = vtkImageShrink3D()
    smooth.SetInputConnection(grab.GetOutputPort())
    smooth.SetShrinkFactors(OVERSAMPLING, OVERSAMPLING, 1)
    smooth.AveragingOn()
    writer = vtkPNGWriter()
    writer.SetInputConnection(smooth.GetOutputPort())
    writer.SetFileName(str(file))
    writer.Write()


def window(panels, lights):
    """A window side by side for that many renderers."""
    window = blank(WIDTH, HEIGHT)
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


def fill(window, i, title, caption, *actors):
    """Put actors into a panel, below its title."""
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


def render(window, view, middle, scale, file, others=()):
    """Write the picture of all panels, seen from the direction `view` of `middle`.

    `others` maps panels to directions of their own.
    """
    for number in range(window.GetRenderers().GetNumberOfItems()):
        scene = window.GetRenderers().GetItemAsObject(number)
        towards = dict(others).get(number, view)
        camera = scene.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetParallelScale(scale)
        camera.SetFocalPoint(middle)
        camera.SetPosition(np.array(middle) + 600 * np.array(towards))
        camera.SetViewUp(0, 0, 1)
        scene.ResetCameraClippingRange()
    draw(window, file)
