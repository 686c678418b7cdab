"""Draw docs/paraview_bones.png: `pvpython docs/paraview_bones.py`, with a display (or `xvfb-run`).

You will see a slice of an image with the outlines of two closed surfaces, at rest and after one of
them was turned by a Transform; the image inside turns with it.
"""

from __future__ import annotations

from pathlib import Path

from paraview import simple

FOLDER = Path(__file__).resolve().parent
simple.LoadPlugin(str(FOLDER.parent / "paraview_plugin/vtk_mls_plugin.py"), ns=vars(simple))


def bones(angle):
    """Two long bones in one dataset; one is turned by an angle about the joint."""
    parts = []
    for y, turn in ((-13.0, 0.0), (13.0, angle)):
        ball = simple.Sphere(ThetaResolution=32, PhiResolution=32)
        bone = simple.Transform(Input=ball)
        bone.Transform.Scale, bone.Transform.Translate = [12.0, 22.0, 12.0], [0.0, y, 0.0]
        part = simple.Transform(Input=bone)
        part.Transform.Rotate = [0.0, 0.0, turn]
        parts.append(part)
    return simple.AppendGeometry(Input=parts)


def draw(view, image, surface, title):
    """A slice through the image, the outlines of the bones in it, and a title."""
    for source, color in ((image, None), (surface, [0.0, 0.0, 0.0])):
        part = simple.Slice(Input=source)
        part.SliceType.Normal = [0.0, 0.0, 1.0]
        part.SliceType.Origin = [0.0, 0.0, 0.0]
        display = simple.Show(part, view)
        if color:
            display.ColorArrayName = ["POINTS", ""]
            display.AmbientColor = display.DiffuseColor = color
            display.LineWidth = 4.0
            display.Position = [0.0, 0.0, 0.1]
        else:
            simple.ColorBy(display, ("POINTS", "RTData"))
            display.SetScalarBarVisibility(view, False)
    text = simple.Show(simple.Text(Text=title), view)
    text.FontSize, text.Color = 18, [0.0, 0.0, 0.0]
    view.CameraPosition, view.CameraFocalPoint = [0.0, 0.0, 150.0], [0.0, 0.0, 0.0]
    view.CameraParallelProjection, view.CameraParallelScale = 1, 34.0


image = simple.Wavelet(WholeExtent=[-32, 32, -32, 32, -14, 14], XFreq=30, YFreq=30, ZFreq=0)
rest, moved = bones(0.0), bones(50.0)
deform = simple.MLSDeform(Input=image, ControlPoints=rest, DeformedControlPoints=moved)
deform.HandleShapes, deform.MapTolerance = "cells", 0.0
layout = simple.CreateLayout("bones")
for number, (source, surface, title) in enumerate(
    ((image, rest, "Control Points"), (deform, moved, "Deformed Control Points"))
):
    settings = {"ViewSize": [450, 450], "OrientationAxesVisibility": 0}
    view = simple.CreateRenderView(UseColorPaletteForBackground=0, **settings)
    view.Background = [1.0, 1.0, 1.0]
    if number == 0:
        layout.SplitHorizontal(0, 0.5)
    layout.AssignView(number + 1, view)
    draw(view, source, surface, title)
layout.SetSize(900, 450)
simple.SaveScreenshot(str(FOLDER / "paraview_bones.png"), layout, ImageResolution=[900, 450])
