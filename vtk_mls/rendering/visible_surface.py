"""The visible surface of a view: world positions at pixels."""

import numpy as np
from vtkmodules.vtkCommonCore import vtkCommand, vtkFloatArray

from vtk_mls.rendering.projection import Projection
from vtk_mls.rendering.volume_ray import opaque_at
from vtk_mls.vtk import arrays


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
        self._projection = Projection(renderer)

    def at(self, x, y):
        """The position (3,) of the surface at a pixel, from the lower left corner of the window.

        On the first mesh or where a volume becomes opaque, whichever is nearer; None without both.
        """
        column, row = np.array([x, y]) - self._origin
        if not (0 <= column < self._size[0] and 0 <= row < self._size[1]):
            return None
        depth = float(self._depth[row, column])
        start, end = self._projection.world([[x + 0.5, y + 0.5]] * 2, np.array([-1, 2 * depth - 1]))
        found = [opaque_at(volume, start, end) for volume in self._volumes]
        first = min((fraction for fraction in found if fraction is not None), default=1.0)
        if first == 1 and depth == 1:
            return None
        return start + first * (end - start)
