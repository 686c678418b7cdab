"""What the editor draws: data, handles and texts, in the renderers of a window."""

from __future__ import annotations

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  draws
from vtkmodules.vtkCommonCore import vtkCommand
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkRenderer

from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor.handle_glyphs import HandleGlyphs
from vtk_mls.editor.projection import Projection
from vtk_mls.editor.shown_mesh import ShownMesh
from vtk_mls.editor.shown_volume import ShownVolume

TOP, BOTTOM = (0.16, 0.19, 0.25), (0.05, 0.06, 0.09)
_FROM = np.array((0.55, -1.0, 0.45))  # where the eye is at first: to the left, in front, above


class Scene:
    """Datasets and handles in a vtkRenderWindow.

    Parameters
    ----------
    window : vtkRenderWindow
        The first of its renderers is used if it has one.
    datasets : list of vtkDataSet

    Attributes
    ----------
    renderer, overlay : vtkRenderer
    shown : list of ShownVolume and ShownMesh
    glyphs : HandleGlyphs
    """

    def __init__(self, window, datasets):
        self.window, self.renderer = window, window.GetRenderers().GetFirstRenderer()
        if self.renderer is None:
            self.renderer = vtkRenderer()
            self.renderer.GradientBackgroundOn()
            self.renderer.SetBackground(BOTTOM)
            self.renderer.SetBackground2(TOP)
            window.AddRenderer(self.renderer)
        self.overlay = vtkRenderer()
        self.overlay.SetLayer(window.GetNumberOfLayers())
        self.overlay.InteractiveOff()
        window.SetNumberOfLayers(window.GetNumberOfLayers() + 1)
        window.AddRenderer(self.overlay)
        self.shown = [_shown(each, self.renderer) for each in datasets]
        self.glyphs = HandleGlyphs(self.renderer, self.overlay)
        self._tag = self.renderer.AddObserver(vtkCommand.StartEvent, self._fit)
        self.reset_camera(_FROM)

    @property
    def bounds(self):
        """Corners (2, 3) of a box round what is seen of the data at rest."""
        corners = np.array([each.bounds for each in self.shown])
        return np.array([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])

    @property
    def projection(self):
        """The `Projection` of now."""
        return Projection(self.renderer)

    def show(self, deformation, nodes, is_final):
        """Draw data as a Deformation has them, or undeformed for None, from the next picture on."""
        for each in self.shown:
            each.show(deformation, nodes, is_final)

    def set_look(self, number):
        """Draw all data by one of their looks; the names of these."""
        return ", ".join(each.set_look(number) for each in self.shown)

    def set_coarseness(self, pixels):
        """Cast a ray for each so many pixels along both axes."""
        for each in self.shown:
            each.set_coarseness(pixels)

    def surfaces(self):
        """What one sees now, of which rays can ask."""
        return Surfaces([each.surface() for each in self.shown], self.bounds.mean(axis=0))

    def reset_camera(self, seen_from=None):
        """See all of it, from a direction or as before."""
        camera = self.renderer.GetActiveCamera()
        if seen_from is not None:
            camera.SetFocalPoint(0, 0, 0)
            camera.SetPosition(seen_from)
            camera.SetViewUp(0, 0, 1)
        self.renderer.ResetCamera(self.bounds.T.ravel())
        self.renderer.ResetCameraClippingRange()

    def detach(self):
        """Leave the data as they are at rest, and the renderer to itself."""
        self.renderer.RemoveObserver(self._tag)
        for each in self.shown:
            each.detach()

    def _fit(self, renderer, event):
        # a camera of its own, for whoever exchanges cameras for a picture
        self.overlay.GetActiveCamera().DeepCopy(self.renderer.GetActiveCamera())
        self.glyphs.fit(self.projection)


class Surfaces:
    """The visible surfaces of several data."""

    def __init__(self, surfaces, middle):
        self._surfaces, self._middle = surfaces, middle

    def hit(self, projection, pixel):
        """The point (3,) that is seen at a pixel; None beside the data."""
        ray = projection.ray(pixel)
        hits = [hit for hit in (each.hit(*ray) for each in self._surfaces) if hit]
        return min(hits, key=lambda hit: hit[0])[1] if hits else None

    def normal(self, point):
        """A unit vector (3,) out of what is near a point."""
        for each in self._surfaces:
            normal = each.normal(point)
            if normal is not None:
                return normal
        out = unit(point - self._middle)
        return out if out.any() else np.array((0.0, 0.0, 1.0))


def _shown(dataset, renderer):
    is_volume = isinstance(dataset, vtkImageData) and min(dataset.GetDimensions()) > 1
    return (ShownVolume if is_volume else ShownMesh)(dataset, renderer)
