"""An editor in an offscreen window, and simulated mouse and key events."""

from __future__ import annotations

import sys

import numpy as np
import vtkmodules.vtkInteractionStyle  # noqa: F401  (registers interactors)
from pipelines import ball, picture_of
from vtk_fixtures import scalar_image
from vtkmodules.vtkFiltersCore import vtkTriangleFilter
from vtkmodules.vtkFiltersSources import vtkCylinderSource
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkRenderWindowInteractor

from vtk_mls.editor import Editor
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured, output_of

SIZE = 24
MIDDLE = (SIZE - 1) / 2


def ball_image(geometry=None):
    """An image of a ball, 200 inside and 0 outside."""
    geometry = geometry or ImageGeometry((0, SIZE - 1) * 3)
    radius = np.linalg.norm(geometry.grid.indices() - MIDDLE, axis=1)
    values = np.clip(200 * (SIZE / 3 + 0.5 - radius), 0, 200).astype(np.uint8)
    return scalar_image(values, geometry)


def ball_mesh(offset=(0, 0, 0)):
    """The surface of the same ball, moved by an offset."""
    return ball(MIDDLE + np.array(offset), SIZE / 3)


def key_and_modifiers(symbol):
    """The arguments of `Hands.press` for the name of a key in `commands.COMMANDS`."""
    *modifiers, key = symbol.split("+") if len(symbol) > 1 else [symbol]
    return key, " ".join(modifiers) + " Shift" * (key == "Z")


def pixels_in(pane, points):
    """Pixels (n, 2) of points (n, 3) or (3,) in a `SlicePane`."""
    return pane.projection.pixels(np.reshape(points, (-1, 3)).astype(float))[:, :2]


def bone(is_closed=True):
    """A cylinder in the middle of the ball, along y; without its caps if it is not closed."""
    source = configured(vtkCylinderSource(), Center=[MIDDLE] * 3, Radius=2, Height=8)
    configured(source, Resolution=24, Capping=is_closed)
    return output_of(vtkTriangleFilter(), InputData=output_of(source))


class Hands:
    """Moves the mouse and presses keys in the window of an editor."""

    def __init__(self, data, state=None, pixels=240, **options):
        window = configured(vtkRenderWindow(), OffScreenRendering=True, MultiSamples=0)
        window.SetSize(pixels, pixels)
        self.interactor = vtkRenderWindowInteractor()
        self.interactor.SetRenderWindow(window)
        self.interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
        # without this observer VTK would end an event loop that does not run
        self.interactor.AddObserver("ExitEvent", lambda *_: None)
        self.editor = Editor(self.interactor, data, state, **options)
        self._pixel = np.zeros(2, int)

    def send(self, event, pixel=None, keys="", symbol=None):
        """Send an event with the pixel of the mouse, modifiers, and the symbol of a key."""
        self._pixel = self._pixel if pixel is None else np.rint(pixel).astype(int)
        x, y = self._pixel.tolist()
        code = symbol if symbol and len(symbol) == 1 else chr(0)
        modifiers = int("Ctrl" in keys), int("Shift" in keys)
        self.interactor.SetEventInformation(x, y, *modifiers, code, 0, symbol)
        # VTK prints exceptions of observers, and continues
        raised, usual = [], sys.excepthook
        sys.excepthook = lambda kind, error, trace: raised.append(error)
        try:
            self.interactor.InvokeEvent(event)
        finally:
            sys.excepthook = usual
        if raised:
            raise raised[0]

    def tick(self):
        self.send("TimerEvent")

    def press(self, symbol, keys=""):
        for event in ("KeyPressEvent", "CharEvent", "KeyReleaseEvent"):
            self.send(event, None, keys, symbol)

    def move(self, pixel, keys=""):
        self.send("MouseMoveEvent", pixel, keys)

    def drag(self, start, by, keys="", steps=4, released=True):
        """Drag from the pixel `start` by an offset in pixels."""
        start, by = np.array(start, float), np.array(by, float)
        self.move(start, keys)
        self.send("LeftButtonPressEvent", start, keys)
        for step in range(1, steps + 1):
            self.move(start + by * step / steps, keys)
            self.tick()
        if released:
            self.send("LeftButtonReleaseEvent", start + by, keys)

    def click(self, pixel, keys=""):
        self.drag(pixel, (0, 0), keys, steps=1)

    @property
    def state(self):
        return self.editor.state

    @property
    def message(self):
        return self.editor.message

    def hit(self, pixel):
        """The visible point (3,) at a pixel."""
        return self.editor.scene.picker().hit(pixel)

    def pixels(self, points):
        """Pixels and depths (n, 3) of points (n, 3)."""
        return self.editor.scene.projection.pixels(points)

    def pixel_of(self, row):
        """The pixel (2,) of a grip."""
        return self.pixels(self.state.grips.deformed[[row]])[0, :2]

    def picture(self):
        """(height, width, 3) float, 0 to 255."""
        window = self.editor.scene.window
        window.Render()
        return picture_of(window)

    @property
    def camera(self):
        camera = self.editor.scene.renderer.GetActiveCamera()
        return camera.GetPosition(), camera.GetFocalPoint()
