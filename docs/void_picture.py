"""Draw docs/void.png: `python docs/void_picture.py`, with `.[docs,cpu]` installed.

You will see the face of the demo's cut close up: with the steps of the voxels, as a contour of the
array Void, and smooth, as one of VoidDistance.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "demo"))
from brain_picture import BRAIN, SURFACE, clipped, contour, opened, shaded
from demo_drawing import fill, render, window
from demo_scene import add, brain

MIDDLE, VIEW = (141.0, 90.0, 125.0), (1.0, 0.55, 0.6)
LIGHTS = {(0.9, 0.38, 0.34): 1.05, (0.0, 0.8, 0.6): 0.18}


def draw(file):
    """Draw the picture."""
    cut = opened(brain())
    solid = 1 - vtk_to_numpy(cut.GetPointData().GetArray("Void")).astype(np.float32)
    add(cut, "Solid", solid)
    outside = clipped(contour(cut, "T1", SURFACE), "VoidDistance", 0.0)
    faces = {
        ("Void, 0 or 1", "contour at one half: steps of voxels"): ("Solid", 0.5),
        ("VoidDistance", "contour at zero: the face of the cut"): ("VoidDistance", 0.0),
    }
    panels = window(len(faces), LIGHTS)
    for i, (titles, (name, value)) in enumerate(faces.items()):
        face = clipped(contour(cut, name, value), "T1", SURFACE)
        lit = shaded(face, "Gradients"), shaded(outside, "Turned", BRAIN)
        fill(panels, i, *titles, *lit)
    render(panels, VIEW, MIDDLE, 21, file)


if __name__ == "__main__":
    draw(Path(__file__).with_name("void.png"))
