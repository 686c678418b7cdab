"""Draw docs/opened.webp: `python docs/brain_animation.py`, with `.[docs,cpu]` installed.

You will see the brain of the demo: a half-plane cuts it from above, and the handles pull it open.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "demo"))
from brain_picture import BRAIN, SURFACE, clipped, contour, opened, shaded, sheet
from demo_drawing import BACKGROUND, blank, draw, illuminate, look
from demo_scene import LIGHTS, VIEW, brain, marked
from vtkmodules.vtkRenderingCore import vtkRenderer

from vtk_mls.commands import demo

SIZE = 640, 560  # pixels
MIDDLE = (98.0, 118.0, 76.0)  # of the picture, in mm
SCALE = 92  # half the height, in mm
CUTTING, OPENING = 8, 26  # frames
MILLISECONDS, PAUSE, END = 60, 700, 2000


def draw_animation(file):
    """Draw the animation."""
    image = brain()
    whole = shaded(contour(image, "T1", SURFACE), "Turned", BRAIN)
    rest, _ = demo.control_points()
    scenes = [[whole, *marked(rest)]]
    scenes += [[*scenes[0], sheet(depth)] for depth in np.linspace(0, 1, CUTTING + 1)[1:]]
    frames = [picture(scene) for scene in scenes]
    for time in np.linspace(0, 1, OPENING + 1)[1:]:
        degrees = demo.DEGREES * (1 - np.cos(np.pi * time)) / 2
        frames.append(picture(open_brain(image, degrees)))
    durations = [MILLISECONDS] * len(frames)
    durations[0], durations[CUTTING], durations[-1] = PAUSE, PAUSE, END
    first, *others = frames
    first.save(file, save_all=True, append_images=others, duration=durations, loop=0, quality=80)


def open_brain(image, degrees):
    """Actors of the brain whose halves are turned outward."""
    cut = opened(image, degrees)
    outside = clipped(contour(cut, "T1", SURFACE), "VoidDistance", 0.0)
    face = clipped(contour(cut, "VoidDistance", 0.0), "T1", SURFACE)
    lit = shaded(outside, "Turned", BRAIN), shaded(face, "Gradients")
    return [*lit, *marked(demo.control_points(degrees)[1])]


def picture(actors):
    """A picture of actors."""
    window, scene = blank(*SIZE), vtkRenderer()
    window.AddRenderer(scene)
    illuminate(scene, LIGHTS)
    scene.SetBackground(BACKGROUND)
    for actor in actors:
        scene.AddActor(actor)
    look(scene, VIEW, MIDDLE, SCALE)
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        draw(window, file.name)
        return Image.open(file.name).convert("RGB")


if __name__ == "__main__":
    draw_animation(Path(__file__).with_name("opened.webp"))
