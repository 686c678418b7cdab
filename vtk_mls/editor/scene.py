"""The renderers of the editor with data and handles."""

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  renders
from vtkmodules.vtkCommonCore import vtkCommand, vtkLogger
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingAnnotation import vtkAnnotatedCubeActor
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor.handle_glyphs import HandleGlyphs
from vtk_mls.editor.scene_image import SceneImage
from vtk_mls.editor.scene_mesh import SceneMesh
from vtk_mls.editor.scene_volume import SceneVolume
from vtk_mls.rendering.projection import Projection
from vtk_mls.vtk.objects import configured

_CUBE = 34  # pixels of the cube with letters
TOP, BOTTOM = (0.16, 0.19, 0.25), (0.05, 0.06, 0.09)  # colors of the background
_INITIAL_DIRECTION = np.array((0.55, -1.0, 0.45))  # to the camera: left, anterior, superior


class Scene:
    """Datasets and handles in a vtkRenderWindow.

    The renderer of the data is by default the first of the window, or a new one.

    Attributes
    ----------
    renderer, overlay : vtkRenderer
    items : list of SceneVolume, SceneImage and SceneMesh
    glyphs : HandleGlyphs
    """

    def __init__(self, window, datasets, renderer=None):
        self.window = window
        self.renderer = renderer or window.GetRenderers().GetFirstRenderer() or new_renderer(window)
        self.overlay = new_layer(window)
        self.items = [_item(dataset, self.renderer) for dataset in datasets]
        self.glyphs, self._cube = HandleGlyphs(self.renderer, self.overlay), _letter_cube()
        self.overlay.AddActor(self._cube)
        self._tag = self.renderer.AddObserver(vtkCommand.StartEvent, self._before_render)
        self.reset_camera(_INITIAL_DIRECTION)

    @property
    def bounds(self):
        """Corners (2, 3) of a box around the visible data at rest."""
        return box_around([item.bounds for item in self.items])

    @property
    def flat_axis(self):
        """The axis of the world that flat images are across, if there is nothing else; or None."""
        axes = {getattr(item, "flat_axis", None) for item in self.items}
        return axes.pop() if len(axes) == 1 else None

    @property
    def layers(self):
        """The renderers of the 3-D view: data, and what is drawn above them."""
        return self.renderer, self.overlay

    def zoom_at(self, pixel, to, factor):
        """Zoom by a factor about a pixel, which moves to the pixel `to`."""
        camera, projection = self.renderer.GetActiveCamera(), self.projection
        focal, position = np.array(camera.GetFocalPoint()), np.array(camera.GetPosition())
        depth = projection.pixels(focal[None])[0, 2]
        start, end = projection.world(np.array([pixel, to]), depth)
        middle = start + (focal - end) / factor
        configured(camera, FocalPoint=middle, Position=middle + (position - focal) / factor)
        self.renderer.ResetCameraClippingRange()

    @property
    def projection(self):
        """The current `Projection`."""
        return Projection(self.renderer)

    def show(self, deformation, nodes, distortion, is_final):
        """Deform the data from the next picture on; None for the identity."""
        for item in self.items:
            item.show(deformation, nodes, distortion, is_final)

    def set_preset(self, index):
        """Draw each dataset with one of its presets; their names."""
        return ", ".join(item.set_preset(index) for item in self.items)

    def replace(self, dataset):
        """Draw another dataset instead of the first."""
        self.items[0].detach()
        self.renderer.RemoveViewProp(self.items[0].prop)
        self.items[0] = _item(dataset, self.renderer)

    def set_coarseness(self, pixels):
        """Set the pixels between rays along both axes."""
        has_offset = any(self.renderer.GetOrigin())
        for item in self.items:
            item.set_coarseness(pixels, has_offset)

    def picker(self):
        """A `Picker` of the data as they are drawn now."""
        surfaces = [item.surface() for item in self.items]
        return Picker(surfaces, self.projection, self.bounds.mean(axis=0))

    def rigid_shape_at(self, pixel):
        """The Shape of the mesh, or of the segment of a label image, at a pixel; None without.

        Other datasets take precedence over the first one, which is deformed.
        """
        ray = self.projection.ray(pixel)
        first, *others = (item.rigid_hit(*ray) for item in self.items)
        hits = [hit for hit in others if hit] or [hit for hit in [first] if hit]
        return min(hits, key=lambda hit: hit[0])[1]() if hits else None

    def reset_camera(self, direction=None):
        """Fit the camera to the data, in a direction from the data or in the current one."""
        camera = self.renderer.GetActiveCamera()
        if direction is not None:
            configured(camera, FocalPoint=(0, 0, 0), Position=direction, ViewUp=(0, 0, 1))
        self.renderer.ResetCamera(self.bounds.T.ravel())
        self.renderer.ResetCameraClippingRange()

    def detach(self):
        """Leave the data undeformed in the renderer."""
        self.renderer.RemoveObserver(self._tag)
        for item in self.items:
            item.detach()

    def _before_render(self, renderer, event):
        # a camera of its own, as programs may replace the camera of the data for a picture
        camera = self.overlay.GetActiveCamera()
        camera.DeepCopy(self.renderer.GetActiveCamera())
        camera.Modified()  # vtkRenderer places names by a matrix that it keeps until then
        self.glyphs.fit(self.projection)
        self._place_cube()

    def _place_cube(self):
        """Place the cube with letters at the lower right of the 3-D view."""
        right = np.multiply(self.renderer.GetSize(), (1, 0)) + np.multiply(_CUBE, (-1, 1))
        corner = np.add(self.renderer.GetOrigin(), right)
        focal = np.array(self.renderer.GetActiveCamera().GetFocalPoint())
        place = self.projection.world(corner, self.projection.pixels(focal[None])[0, 2])
        size = _CUBE * self.projection.pixel_size(place[None])[0]
        configured(self._cube.GetAssembly(), Position=place, Scale=size)


def box_around(boxes):
    """Corners (2, 3) of the box around boxes (n, 2, 3)."""
    return np.array([np.min(boxes, axis=(0, 1)), np.max(boxes, axis=(0, 1))])


def _letter_cube():
    """A cube with the letters of LPS coordinates on its faces."""
    cube = configured(vtkAnnotatedCubeActor(), Pickable=False, FaceTextScale=0.6)
    for axis, letters in zip("XYZ", ("LR", "PA", "SI")):
        for sign, letter in zip(("Plus", "Minus"), letters):
            getattr(cube, f"Set{axis}{sign}FaceText")(letter)
    cube.GetTextEdgesProperty().SetOpacity(0)
    configured(cube.GetCubeProperty(), Color=(0.30, 0.36, 0.46), Lighting=False)
    return cube


def new_window():
    """A vtkRenderWindow; VTK's message that there is no display is hidden."""
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        return vtkRenderWindow()
    finally:
        vtkLogger.SetStderrVerbosity(verbosity)


def new_layer(window):
    """A vtkRenderer above all others of a window."""
    renderer = configured(vtkRenderer(), Layer=window.GetNumberOfLayers(), Interactive=False)
    if hasattr(renderer, "UseOITOff"):  # VTK 9.3
        # in software, translucent parts that need no order take as long as a mesh with it
        renderer.UseOITOff()
    window.SetNumberOfLayers(window.GetNumberOfLayers() + 1)
    window.AddRenderer(renderer)
    return renderer


def new_renderer(window):
    """A vtkRenderer of a window, with the background of the editor."""
    renderer = configured(vtkRenderer(), Background=BOTTOM, Background2=TOP)
    renderer.GradientBackgroundOn()
    window.AddRenderer(renderer)
    return renderer


class Picker:
    """Picks points on the visible surfaces of several datasets."""

    def __init__(self, surfaces, projection, middle):
        self.surfaces, self._projection, self._middle = surfaces, projection, middle

    def hit(self, pixel):
        """The visible point (3,) at a pixel; None beside the data."""
        ray = self._projection.ray(pixel)
        hits = [hit for hit in (surface.hit(*ray) for surface in self.surfaces) if hit]
        return min(hits, key=lambda hit: hit[0])[1] if hits else None

    def normal(self, point):
        """A unit vector (3,) away from the surface near a point."""
        for surface in self.surfaces:
            normal = surface.normal(point)
            if normal is not None:
                return normal
        outwards = unit(point - self._middle)
        return outwards if outwards.any() else np.array((0.0, 0.0, 1.0))


def _item(dataset, renderer):
    if not isinstance(dataset, vtkImageData):
        return SceneMesh(dataset, renderer)
    if min(dataset.GetDimensions()) > 1:
        return SceneVolume(dataset, renderer)
    image = SceneImage(dataset)
    return SceneMesh(dataset, renderer) if image.flat_axis is None else image
