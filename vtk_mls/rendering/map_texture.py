"""The displacement map on the graphics card."""

from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkRenderingOpenGL2 import vtkTextureObject

from vtk_mls.rendering.errors import RenderingError


class MapTexture:
    """A 3-D texture of four floats that follows the window it is drawn in.

    Attributes
    ----------
    uploads : int
        How often values went to the graphics card.
    """

    def __init__(self):
        self.uploads = 0
        self._texture, self._values, self._is_new = vtkTextureObject(), None, False

    def set(self, values):
        """Take the values, (nz, ny, nx, 4) float32 contiguous, to be uploaded when drawn next."""
        self._values, self._is_new = values, True

    def bind(self, window):
        """The unit where shaders of a vtkRenderWindow find the texture."""
        texture = self._texture
        if texture.GetContext() is not window:
            self.free()
            texture.SetContext(window)
            texture.SetMinificationFilter(vtkTextureObject.Linear)
            texture.SetMagnificationFilter(vtkTextureObject.Linear)
            for axis in "STR":
                getattr(texture, f"SetWrap{axis}")(vtkTextureObject.ClampToEdge)
        if self._is_new or not texture.GetHandle():
            nz, ny, nx, _ = self._values.shape
            if not texture.Create3DFromRaw(nx, ny, nz, 4, VTK_FLOAT, self._values):
                raise RenderingError(
                    f"the graphics driver has no 3-D texture of {nx} x {ny} x {nz} points with "
                    "four floats; draw the resampled volume instead"
                )
            self._is_new = False
            self.uploads += 1
        texture.Activate()
        return texture.GetTextureUnit()

    def release(self):
        """Let others have the unit."""
        if self._texture.GetContext() is not None:
            self._texture.Deactivate()

    def free(self):
        """Give back the memory of the graphics card."""
        window = self._texture.GetContext()
        if window is not None:
            self._texture.ReleaseGraphicsResources(window)
        self._texture = vtkTextureObject() if window is not None else self._texture
