"""The surface that is to be seen in a view: where what is drawn at a pixel is in the world."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkCommand, vtkFloatArray

from vtk_mls.rendering.volume_ray import opaque_at


class VisibleSurface:
    """What a view shows at the moment when this is made.

    Parameters
    ----------
    renderer : vtkRenderer
        Its window is drawn once more, unseen.
    without : sequence of vtkProp, optional
        What is not part of the surface, as what the mouse drags along it.
    """

    def __init__(self, renderer, without=()):
        self._volumes = [each for each in _each(renderer.GetVolumes()) if each.GetVisibility()]
        hidden = [prop for prop in without if prop.GetVisibility()]
        for prop in hidden:
            prop.VisibilityOff()
        observer = renderer.AddObserver(vtkCommand.EndEvent, self._drawn)
        window = renderer.GetRenderWindow()
        swaps = window.GetSwapBuffers()
        window.SetSwapBuffers(False)
        window.Render()
        window.SetSwapBuffers(swaps)
        renderer.RemoveObserver(observer)
        for prop in hidden:
            prop.VisibilityOn()

    def _drawn(self, renderer, event):
        self._origin, self._size = np.array(renderer.GetOrigin()), np.array(renderer.GetSize())
        last = (self._origin + self._size - 1).tolist()
        depth = vtkFloatArray()
        renderer.GetRenderWindow().GetZbufferData(*self._origin.tolist(), *last, depth)
        self._depth = vtk_to_numpy(depth).reshape(self._size[::-1])
        matrix = renderer.GetActiveCamera().GetCompositeProjectionTransformMatrix(
            renderer.GetTiledAspectRatio(), 0, 1
        )
        matrix = [[matrix.GetElement(i, j) for j in range(4)] for i in range(4)]
        self._to_world = np.linalg.inv(matrix)

    def at(self, x, y):
        """The point of the surface at a pixel.

        Parameters
        ----------
        x, y : int, pixels of the window from its lower left corner

        Returns
        -------
        (3,) float64, world coordinates, or None
            Of a mesh where it is drawn first, or where a volume hides what is behind; None where
            there is neither.
        """
        column, row = np.array([x, y]) - self._origin
        if not (0 <= column < self._size[0] and 0 <= row < self._size[1]):
            return None
        depth = float(self._depth[row, column])
        start, end = self._world(x, y, 0.0), self._world(x, y, depth)
        found = [opaque_at(volume, start, end) for volume in self._volumes]
        first = min((each for each in found if each is not None), default=1.0)
        if first == 1 and depth == 1:
            return None
        return start + first * (end - start)

    def _world(self, x, y, depth):
        """The point at the centre of a pixel, in a depth from 0 to 1: (3,)."""
        across = 2 * (np.array([x, y]) - self._origin + 0.5) / self._size - 1
        found = self._to_world @ (*across, depth, 1.0)
        return found[:3] / found[3]


def _each(collection):
    return [collection.GetItemAsObject(i) for i in range(collection.GetNumberOfItems())]
