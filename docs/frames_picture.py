"""Draw docs/frames.png: `python docs/frames_picture.py`, with the packages of `make demo`.

You will see a brain with the axes of LPS and of RAS, one control point with its numbers in each,
and where it goes if they are mixed up.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import vtkmodules.vtkRenderingFreeType  # noqa: F401  (text)
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkPolyDataNormals, vtkTubeFilter
from vtkmodules.vtkFiltersSources import vtkConeSource, vtkLineSource
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth
from vtkmodules.vtkRenderingCore import vtkActor, vtkBillboardTextActor3D, vtkPolyDataMapper

from vtk_mls import io
from vtk_mls.commands import demo

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "demo"))
from demo_drawing import DRAGGED, OVERSAMPLING, fill, render, spheres, window

from vtk_mls.files import frames

SURFACE = 105  # T1 at which the brain ends
BRAIN = (0.87, 0.66, 0.60)
AXES = ((0.95, 0.35, 0.35), (0.45, 0.85, 0.45), (0.45, 0.65, 1.0))  # x, y, z
WRONG = (1.0, 0.2, 0.75)
HANDLE = np.array([48.0, -38.0, 52.0])  # left, front, above; LPS
EYE, MIDDLE = np.array([0.8, -0.7, 0.5]), (0.0, 10.0, 18.0)  # of LPS
ABOVE = np.array([0.0, -0.35, 1.0])  # where the eye is in the third part
LIGHTS = {(0.2, -0.9, 0.9): 1.0, (0.9, 0.3, 0.3): 0.5}
NAMES = {"L": "left", "R": "right", "P": "back", "A": "front", "S": "up"}


def draw(file):
    """Draw the picture."""
    panels = window(3, LIGHTS)
    brain = _brain()
    for i, (frame, users) in enumerate(
        {
            "LPS": "DICOM, ITK, ANTs, files of 3D Slicer, and vtk_mls",
            "RAS": "NIfTI files, nibabel, FreeSurfer, 3D Slicer's own views",
        }.items()
    ):
        numbers = ", ".join(f"{coordinate:g}" for coordinate in HANDLE * frames.signs(frame))
        handle = spheres(HANDLE[None], 5.0, DRAGGED)
        label = _text(f"({numbers})", HANDLE + [0, 0, 12], (1.0, 1.0, 1.0))
        fill(panels, i, frame, users, _surface(brain), handle, label, *_axes(frame))
    wrong, before = HANDLE * frames.signs("RAS"), 200 * ABOVE  # before the brain
    fill(
        panels,
        2,
        "Mixed up",
        "numbers of LPS taken for RAS: the other side of the head",
        _surface(brain),
        *_arrow(HANDLE + before, wrong + before, WRONG),
        spheres(HANDLE[None] + before, 5.0, DRAGGED),
        _text("meant", HANDLE + [0, -16, 0], (1.0, 1.0, 1.0), ABOVE),
        _text("found", wrong + [0, 14, 0], (1.0, 1.0, 1.0), ABOVE),
        _text("left", np.array([100.0, 10, 0]), AXES[0], ABOVE),
        _text("right", np.array([-100.0, 10, 0]), AXES[0], ABOVE),
        _text("front", np.array([0.0, -100, 0]), AXES[1], ABOVE),
    )
    render(panels, EYE, MIDDLE, 128, file, {2: ABOVE})


def _brain():
    """The surface of the brain, in LPS as `io` reads it."""
    smooth, contour, normals = vtkImageGaussianSmooth(), vtkFlyingEdges3D(), vtkPolyDataNormals()
    smooth.SetInputData(io.read_dataset(demo.brain_file()))
    smooth.SetStandardDeviation(0.8)
    contour.SetInputConnection(smooth.GetOutputPort())
    contour.SetValue(0, SURFACE)
    contour.ComputeNormalsOff()
    normals.SetInputConnection(contour.GetOutputPort())
    normals.SplittingOff()
    normals.Update()
    return normals


def _surface(source, color=BRAIN, opacity=1.0):
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(color)
    actor.GetProperty().SetOpacity(opacity)
    actor.GetProperty().SetAmbient(0.2)
    actor.GetProperty().SetDiffuse(0.75)
    return actor


def _axes(frame):
    """Arrows along the axes of a frame, from the edge of the brain outward."""
    for number, (letter, name) in enumerate(zip(frame, "xyz")):
        along = np.eye(3)[number] * frames.signs(frame)
        start, end = along * (62, 75, 75), along * (130, 150, 125)
        yield from _arrow(start, end, AXES[number])
        yield _text(f"{name}: {NAMES[letter]}", end + 18 * along, AXES[number])


def _arrow(start, end, color):
    along = (end - start) / np.linalg.norm(end - start)
    line, shaft, head = vtkLineSource(), vtkTubeFilter(), vtkConeSource()
    line.SetPoint1(start)
    line.SetPoint2(end - 12 * along)
    shaft.SetInputConnection(line.GetOutputPort())
    shaft.SetRadius(1.8)
    shaft.SetNumberOfSides(16)
    head.SetCenter(end - 6 * along)
    head.SetDirection(along)
    head.SetHeight(14)
    head.SetRadius(5)
    head.SetResolution(24)
    return _surface(shaft, color), _surface(head, color)


def _text(text, place, color, eye=EYE):
    actor = vtkBillboardTextActor3D()
    actor.SetInput(text)
    actor.SetPosition(place + 250 * eye)  # before all else
    font = actor.GetTextProperty()
    font.SetFontFamilyToArial()
    font.SetFontSize(26 * OVERSAMPLING)
    font.SetBold(True)
    font.SetColor(color)
    font.SetJustificationToCentered()
    font.SetVerticalJustificationToCentered()
    return actor


if __name__ == "__main__":
    draw(Path(__file__).with_name("frames.png"))
