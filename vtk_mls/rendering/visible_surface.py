"""The visible surface of a view: world positions at pixels."""

import numpy as np
from vtkmodules.vtkCommonCore import vtkCommand, vtkFloatArray

from vtk_mls.rendering.volume_ray import opaque_at
from vtk_mls.vtk import arrays
from vtk_mls.vtk.transforms import matrix_of


class VisibleSurface:
    """The visible surface of a view at the time of construction.

    The window of the renderer is rendered once without showing the picture. Props in `without`,
    such as a marker that the mouse drags along it, are not part of the surface.
    """

    def __init__(self, renderer, without=()):
        self._volumes = [volume for volume in renderer.GetVolumes() if volume.GetVisibility()]
        hidden = [prop for prop in without if prop.GetVisibility()]
        for prop in hidden:
            prop.VisibilityOff()
        observer = renderer.AddObserver(vtkCommand.EndEvent, self._read_depths)
        window = renderer.GetRenderWindow()
        swaps = window.GetSwapBuffers()
        window.SetSwapBuffers(False)
        window.Render()
        window.SetSwapBuffers(swaps)
        renderer.RemoveObserver(observer)
        for prop in hidden:
            prop.VisibilityOn()

    def _read_depths(self, renderer, event):
        self._origin, self._size = np.array(renderer.GetOrigin()), np.array(renderer.GetSize())
        last = (self._origin + self._size - 1).tolist()
        depth = vtkFloatArray()
        renderer.GetRenderWindow().GetZbufferData(*self._origin.tolist(), *last, depth)
        self._depth = arrays.to_numpy(depth).reshape(self._size[::-1])
        matrix = renderer.GetActiveCamera().GetCompositeProjectionTransformMatrix(
            renderer.GetTiledAspectRatio(), 0, 1
        )
        self._to_world = np.linalg.inv(matrix_of(matrix))

    def at(self, x, y):
        """The position (3,) of the surface at a pixel, from the lower left corner of the window.

        On the first mesh or where a volume becomes opaque, whichever is nearer; None without both.
        """
        column, row = np.array([x, y]) - self._origin
        if not (0 <= column < self._size[0] and 0 <= row < self._size[1]):
            return None
        depth = float(self._depth[row, column])
        start, end = self._world(x, y, 0.0), self._world(x, y, depth)
        found = [opaque_at(volume, start, end) for volume in self._volumes]
        first = min((fraction for fraction in found if fraction is not None), default=1.0)
        if first == 1 and depth == 1:
            return None
        return start + first * (end - start)

    def _world(self, x, y, depth):
        """The position (3,) of the center of a pixel at a depth from 0 to 1."""
        across = 2 * (np.array([x, y]) - self._origin + 0.5) / self._size - 1
        position = self._to_world @ (*across, depth, 1.0)
        return position[:3] / position[3]
