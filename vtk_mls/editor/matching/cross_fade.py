"""The picture of one 3-D view over that of another of the same size."""

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  renders
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkImageMapper

from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured


class CrossFade:
    """Copies each picture of a renderer, and draws it behind the objects of a layer.

    The `layer` is above the renderer that is faded out; it has the size of `source`, and no data.
    """

    def __init__(self, source, layer):
        self._source, self._image = source, vtkImageData()
        self._share, self._pixels = 0.0, vtkUnsignedCharArray()
        mapper = configured(vtkImageMapper(), InputData=self._image, ColorWindow=255)
        mapper.SetColorLevel(127.5)
        self._image.AllocateScalars(VTK_UNSIGNED_CHAR, 4)
        self._actor = configured(vtkActor2D(), Mapper=mapper, Pickable=False, Visibility=False)
        self._actor.GetProperty().SetDisplayLocationToBackground()
        layer.AddViewProp(self._actor)
        self._layer = layer
        self._tag = source.AddObserver("EndEvent", self._copy)

    def set_share(self, share):
        """Set the opacity, 0 to 1, from the next picture on."""
        self._share = share
        self._actor.SetVisibility(share > 0)

    def detach(self):
        """Remove the picture from the layer."""
        self._source.RemoveObserver(self._tag)
        self._layer.RemoveViewProp(self._actor)

    def _copy(self, renderer, event):
        if not self._share:
            return
        (left, low), (width, height) = renderer.GetOrigin(), renderer.GetSize()
        corners = left, low, left + width - 1, low + height - 1
        renderer.GetRenderWindow().GetPixelData(*corners, 0, self._pixels, 0)
        colors = arrays.to_numpy(self._pixels).reshape(-1, 3)
        opacity = np.full((len(colors), 1), round(255 * self._share), np.uint8)
        self._image.SetDimensions(width, height, 1)
        scalars = arrays.from_numpy(np.hstack([colors, opacity]), VTK_UNSIGNED_CHAR)
        self._image.GetPointData().SetScalars(scalars)
        self._image.Modified()
