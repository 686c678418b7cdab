"""Draws regions, curves and the mask of a state."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls import CurveHandle
from vtk_mls.editor import polydata
from vtk_mls.editor.handle_glyphs import MASKING, MOVED, RESTING, SELECTED
from vtk_mls.vtk.cells import cell_array, triangle_polydata
from vtk_mls.vtk.objects import configured
from vtk_mls.vtk.shape_surfaces import surface_of

_REGION_OPACITY = 0.3
_CURVE_OPACITY, _REST_OPACITY, _CURVE_WIDTH = 1.0, 0.45, 3.0
_MASK_OPACITIES = 0.55, 0.25  # of the ball, and of the end of its fall-off
_CENTER_SIZE = 13  # pixels
_CIRCLE = np.linspace(0, 2 * np.pi, 97)


class ShapeActors:
    """Draws regions as translucent surfaces, curves as lines, the mask as circles.

    The renderer is a layer above the data, which would hide them.
    """

    def __init__(self, renderer):
        self._renderer, self._regions, self._is_visible = renderer, {}, True
        self._lines = [vtkPolyData() for _ in range(4)]
        soft, amber, violet = (tuple(np.divide(c, 255)) for c in (RESTING, MOVED, MASKING))
        styles = (
            *((soft, 2.0, _REST_OPACITY), (amber, _CURVE_WIDTH, _CURVE_OPACITY)),
            *((violet, 2.0, opacity) for opacity in _MASK_OPACITIES),
        )
        self._actors = [
            polydata.unlit_actor(lines, *style) for lines, style in zip(self._lines, styles)
        ]
        self._centers = vtkPolyData()
        self._actors.append(polydata.unlit_actor(self._centers))
        polydata.show_points_as_balls(self._actors[-1], _CENTER_SIZE)
        for actor in self._actors:
            renderer.AddActor(actor)

    def set_visible(self, is_visible):
        """Show or hide all."""
        self._is_visible = is_visible
        for actor in [*self._actors, *self._regions.values()]:
            actor.SetVisibility(is_visible)

    def show(self, state, selected):
        """Draw the regions, curves and mask of a `State`; `selected` are rows of its grips."""
        curves = [handle for handle in state.handles if isinstance(handle, CurveHandle)]
        chosen = [state.handles[owner] for owner in state.grips.owner[selected] if owner >= 0]
        self._show_regions(state.regions, chosen)
        _set_lines(self._lines[0], [curve.rest for curve in curves])
        _set_lines(self._lines[1], [curve.deformed for curve in curves])
        mask = state.mask
        radii = (0, 0) if mask is None else (mask.radius, mask.radius + mask.falloff)
        for lines, radius in zip(self._lines[2:], radii):
            _set_lines(lines, [] if mask is None else _circles(mask.center, radius))

    def _show_regions(self, regions, chosen):
        shapes = {region.shape for region in regions}
        for shape in [shape for shape in self._regions if shape not in shapes]:
            self._renderer.RemoveActor(self._regions.pop(shape))
        colors = [SELECTED if region in chosen else MOVED for region in regions]
        centers = [region.center[1] for region in regions]
        self._centers.SetPoints(polydata.points(np.reshape(centers, (-1, 3))))
        self._centers.SetVerts(polydata.cells(np.arange(len(centers))[:, None]))
        self._centers.GetCellData().SetScalars(polydata.colors(np.reshape(colors, (-1, 3))))
        for region, color in zip(regions, colors):
            if region.shape not in self._regions:
                actor = self._regions[region.shape] = _region_actor(region.shape)
                actor.SetVisibility(self._is_visible)
                self._renderer.AddActor(actor)
            actor, matrix = self._regions[region.shape], vtkMatrix4x4()
            matrix.DeepCopy(region.motion.ravel())
            actor.SetUserMatrix(matrix)
            actor.GetProperty().SetColor(np.divide(color, 255))


def moved_surface(region):
    """A vtkPolyData of the surface of a RegionHandle after its motion."""
    points, triangles = surface_of(region.shape)
    return triangle_polydata(region.moved(points), triangles)


def _region_actor(shape):
    mapper = configured(vtkPolyDataMapper(), InputData=triangle_polydata(*surface_of(shape)))
    mapper.ScalarVisibilityOff()
    actor = configured(vtkActor(), Mapper=mapper, Pickable=False)
    material = configured(actor.GetProperty(), Ambient=0.35, Diffuse=0.75)
    configured(material, Opacity=_REGION_OPACITY, BackfaceCulling=True)
    return actor


def _circles(center, radius):
    """Three circles (97, 3) around a center, across the axes."""
    across = np.stack([np.cos(_CIRCLE), np.sin(_CIRCLE)], axis=1)
    return [center + radius * np.insert(across, axis, 0.0, axis=1) for axis in range(3)]


def _set_lines(target, lines):
    offsets = np.cumsum([0, *map(len, lines)])
    target.SetPoints(polydata.points(np.concatenate([np.zeros((0, 3)), *lines])))
    target.SetLines(cell_array(np.arange(offsets[-1]), offsets))
