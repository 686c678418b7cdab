"""The opening of a cut shows the background in all representations.  Argument: a folder."""

import sys
from pathlib import Path

import numpy as np
from paraview import simple
from scene import REST, control_points, data, screenshot, wavelet

from vtk_mls.filters.derived_arrays import CAN_HIDE_CELLS

FOLDER = Path(sys.argv[1])
WIDTH, HEIGHT, SCALE = 500, 450, 13.0
GAP = 6.0, 0.0  # a place in the opening: z and x

# The upper half is pulled apart at x = 0.
pulled = REST + np.where(REST[:, 2:] > 0, np.sign(REST[:, :1]) * [[3.0, 0, 0]], 0)
settings = {"Input": wavelet(), "ControlPoints": control_points(REST, pulled)}
settings |= {"CutType": "half-plane", "CutOrigin": [0.3, 0, -2], "OutputGrid": "fitted"}
settings |= {"CutNormal": [1.0, 0.0, 0.0], "CutInward": [0.0, 0.0, 1.0]}
deform = simple.MLSDeform(**settings)
continued = simple.MLSDeform(**settings, HideVoid=0, VoidValues="continued")
data(deform)
data(continued)


def at_face(kind, source, scalars, value):
    """A clip or contour; ParaView would overwrite a value that is set before the scalars."""
    if kind is simple.Contour:
        return kind(Input=source, ContourBy=["POINTS", scalars], Isosurfaces=[value])
    face = kind(Input=source, ClipType="Scalar", Scalars=["POINTS", scalars])
    face.Value, face.Invert = value, 0
    return face


middle = simple.Slice(Input=deform)
middle.SliceType.Normal, middle.SliceType.Origin = [0.0, 1.0, 0.0], [0.0, 0.4, 0.0]
contour = at_face(simple.Contour, continued, "RTData", 130.0)
contour.ComputeScalars = 1
pictures = {
    "volume": (deform, "Volume"),
    "slice": (middle, "Surface"),
    "clip": (at_face(simple.Clip, continued, "VoidDistance", 0.0), "Surface"),
    "contour": (at_face(simple.Clip, contour, "VoidDistance", 0.0), "Surface"),
}
if CAN_HIDE_CELLS:
    pictures["surface"] = (deform, "Surface")

view = simple.CreateRenderView(ViewSize=[WIDTH, HEIGHT])
view.OrientationAxesVisibility = 0
view.UseColorPaletteForBackground = 0
view.BackgroundColorMode = "Single Color"
view.Background = [0.0, 0.0, 1.0]
view.CameraParallelProjection = 1
view.CameraParallelScale = SCALE
view.CameraPosition = [0.0, -60.0, 2.0]
view.CameraFocalPoint, view.CameraViewUp = [0.0, 0.0, 2.0], [0.0, 0.0, 1.0]
for name, (source, kind) in pictures.items():
    display = simple.Show(source, view)
    display.SetRepresentationType(kind)
    simple.Render(view)
    if name != "contour" and source.PointData.GetArray("RTData"):  # 5.11's Clip drops it
        simple.ColorBy(display, ("POINTS", "RTData"))
    # through the opening, for the test; from the side, for people
    for place, towards in (("", [0.0, -60.0, 2.0]), ("_aside", [25.0, -50.0, 30.0])):
        view.CameraPosition = towards
        simple.Render(view)
        pixels = screenshot(view, FOLDER / f"cut_{name}{place}.png")
        if place:
            continue
        per_unit = HEIGHT / (2 * SCALE)
        row, column = HEIGHT // 2 + (GAP[0] - 2) * per_unit, WIDTH // 2 + GAP[1] * per_unit
        assert pixels[round(row), round(column)].tolist() == [0, 0, 255], name
        drawn = (pixels != [0, 0, 255]).any(axis=2).mean()
        assert drawn > 0.1, (name, drawn)
    simple.Hide(source, view)
