"""pvpython
========

Twist a volume in ParaView by eight control points.

Run:  pvpython examples/paraview_deform.py [FOLDER]

You will see, in FOLDER/paraview_deform.png: on the left a square bar, which is a contour of one
array of a volume colored by another, with the control points at its ends; on the right the same
volume after the four upper ones were carried round by a quarter turn.  At the end the displacement
field must point, at every control point, back to where it came from.
"""
# ruff: noqa: F403, F405

import sys
from pathlib import Path

import numpy as np
from paraview import servermanager
from paraview.simple import *

PLUGIN = Path(__file__).resolve().parents[1] / "paraview_plugin" / "vtk_mls_plugin.py"
LoadPlugin(str(PLUGIN), ns=globals())
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

wavelet = Wavelet(WholeExtent=[-15, 15, -15, 15, -26, 26])
bar = Calculator(Input=wavelet, ResultArrayName="bar", Function="max(abs(coordsX), abs(coordsY))")

rest = np.array([(x, y, z) for z in (-24, 24) for y in (-8, 8) for x in (-8, 8)], float)
deformed = rest.copy()
deformed[4:, 0], deformed[4:, 1] = -rest[4:, 1], rest[4:, 0]
start = MLSControlPoints(RestPoints=list(rest.ravel()))
handles = MLSControlPoints(RestPoints=list(rest.ravel()), DeformedPoints=list(deformed.ravel()))
twisted = MLSDeform(Input=bar, ControlPoints=handles, Kind="rigid", Background=15.0)
moved = WarpByVector(Input=handles, Vectors=["POINTS", "Displacement"])

layout = CreateLayout()
layout.SplitHorizontal(0, 0.5)
for place, image, points in ((1, bar, start), (2, twisted, moved)):
    view = CreateView("RenderView")
    AssignViewToLayout(view, layout, place)
    view.OrientationAxesVisibility = 0
    surface = Show(Contour(Input=image, ContourBy=["POINTS", "bar"], Isosurfaces=[7]), view)
    ColorBy(surface, ("POINTS", "RTData"))
    balls = Glyph(Input=points, GlyphType="Sphere", GlyphMode="All Points", ScaleFactor=3)
    balls.OrientationArray = balls.ScaleArray = ["POINTS", "No array"]
    shown = Show(balls, view)
    shown.ColorArrayName = ["POINTS", ""]
    shown.AmbientColor = shown.DiffuseColor = [1.0, 0.8, 0.0]
    view.CameraPosition, view.CameraFocalPoint = [60, -100, 60], [0, 0, 0]
    view.CameraViewUp = [0, 0, 1]
SaveScreenshot(str(folder / "paraview_deform.png"), layout, ImageResolution=[1000, 700])

field = MLSDisplacementField(Input=bar, ControlPoints=handles)
field.UpdatePipeline()
image = servermanager.Fetch(field)
vectors = image.GetPointData().GetArray("BackwardDisplacement")
back = np.array([q + vectors.GetTuple3(image.FindPoint(q)) for q in deformed])
error = np.abs(back - rest).max()
print(f"largest distance from a control point's own place: {error:.1e}")
assert error < 1e-4
