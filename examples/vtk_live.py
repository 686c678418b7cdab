"""Drawn while it moves
====================

Draw a volume and a mesh as they are opened along a cut, without resampling.

Run: python examples/vtk_live.py [picture.png]
"""

import sys

import numpy as np
import vtkmodules.vtkRenderingOpenGL2
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  (registers what draws)
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkFiltersCore import vtkContourFilter
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkColorTransferFunction,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkVolume,
    vtkWindowToImageFilter,
)
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

from vtk_mls import Deformation, HalfPlane
from vtk_mls.rendering import DeformedMesh, DeformedVolume

wavelet = vtkRTAnalyticSource()
wavelet.SetWholeExtent(-32, 32, -32, 32, -32, 32)
wavelet.SetStandardDeviation(0.4)

colors, opacity = vtkColorTransferFunction(), vtkPiecewiseFunction()
for value, *color in ((60, 0.3, 0.5, 0.9), (130, 0.9, 0.9, 0.9), (200, 0.9, 0.4, 0.3)):
    colors.AddRGBPoint(value, *color)
for point in ((70, 0), (90, 0.4), (220, 0.7)):
    opacity.AddPoint(*point)
mapper = vtkGPUVolumeRayCastMapper()
mapper.SetInputConnection(wavelet.GetOutputPort())
mapper.SetAutoAdjustSampleDistances(False)
mapper.SetSampleDistance(0.4)
volume = vtkVolume()
volume.SetMapper(mapper)
volume.GetProperty().SetColor(colors)
volume.GetProperty().SetScalarOpacity(opacity)
volume.GetProperty().SetInterpolationTypeToLinear()
volume.GetProperty().ShadeOn()
volume.GetProperty().SetAmbient(0.4)

contour = vtkContourFilter()
contour.SetInputConnection(wavelet.GetOutputPort())
contour.SetValue(0, 200)
mapper = vtkPolyDataMapper()
mapper.SetInputConnection(contour.GetOutputPort())
mapper.ScalarVisibilityOff()
actor = vtkActor()
actor.SetMapper(mapper)
actor.GetProperty().SetColor(0.9, 0.75, 0.4)

renderer, window = vtkRenderer(), vtkRenderWindow()
renderer.SetBackground(0.1, 0.12, 0.16)
renderer.AddVolume(volume)
renderer.AddActor(actor)
window.AddRenderer(renderer)
window.SetSize(400, 400)
window.SetOffScreenRendering(True)
renderer.GetActiveCamera().SetPosition(75, -150, 130)
renderer.GetActiveCamera().SetViewUp(0, 0, 1)

# the corners of a box, of which the right ones are pulled away from the left ones
rest = np.array([(x, y, z) for x in (-28, 28) for y in (-28, 28) for z in (-28, 28)], float)
cut = HalfPlane((0, 0, -10), (1, 0, 0), (0, 0, 1))
shown = [DeformedVolume(volume, renderer), DeformedMesh(actor)]
for distance in np.linspace(0, 14, 8):  # what an observer of a dragged handle would do
    deformed = rest + (rest[:, :1] > 0) * [distance, 0, 0]
    deformation = Deformation(rest, deformed, cuts=cut)
    for each in shown:
        each.update(deformation)
    window.Render()

print(f"{shown[0].uploads} moves, as many maps on the graphics card, the volume once")
assert shown[0].failure is None
assert shown[0].uploads == 8
grab, writer = vtkWindowToImageFilter(), vtkPNGWriter()
grab.SetInput(window)
grab.ReadFrontBufferOff()
writer.SetInputConnection(grab.GetOutputPort())
writer.SetFileName(sys.argv[1] if len(sys.argv) > 1 else "live.png")
writer.Write()
