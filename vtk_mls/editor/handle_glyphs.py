"""Grips as balls, and lines from their rest positions."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkGlyph3DMapper

from vtk_mls.editor import polydata
from vtk_mls.editor.grips import MASK
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

# Colors, 0 to 255.
RESTING, MOVED, ANCHORED = (205, 212, 222), (255, 150, 40), (80, 160, 255)
LEFT_OUT = (105, 110, 120)
SELECTED, DRAGGED, MASKING = (70, 230, 120), (255, 70, 110), (190, 150, 255)
DRAWN = (255, 89, 115)  # lines of cuts and curves until they end
_OPACITIES = 1.0, 0.3  # in front of the data, and where data hide a handle
_RADIUS, _RESTING_RADIUS, _HOVER_GROWTH = 6.5, 5.0, 3.0  # pixels


def handle_colors(state, selected, dragged):
    """Colors (g, 3), 0 to 255, of the grips of a `State`."""
    grips = state.grips
    are_resting = (grips.rest == grips.deformed).all(axis=1)
    colors = np.where(are_resting[:, None], RESTING, MOVED)
    colors[grips.anchored] = ANCHORED
    colors[: len(state)][~state.enabled] = LEFT_OUT
    colors[grips.owner == MASK] = MASKING
    colors[selected] = SELECTED
    colors[dragged] = DRAGGED
    return colors.astype(np.uint8)


class HandleGlyphs:
    """Draws grips with a constant size in pixels: among the data, and faintly in a layer above."""

    def __init__(self, renderer, overlay):
        self._balls, self._lines, self._actors = vtkPolyData(), vtkPolyData(), []
        self._pixels = np.zeros(0)
        for layer, opacity in zip((renderer, overlay), _OPACITIES):
            line = polydata.unlit_actor(self._lines, tuple(np.divide(MOVED, 255)), 2, opacity)
            for actor in (_ball_actor(self._balls, opacity), line):
                self._actors.append(actor)
                layer.AddActor(actor)

    def set_visible(self, is_visible):
        """Show or hide all handles."""
        for actor in self._actors:
            actor.SetVisibility(is_visible)

    def show(self, rest, deformed, colors, hovered):
        """Draw balls at `deformed` (g, 3), with lines from other positions `rest`.

        The ball `hovered`, if any, is larger.
        """
        resting = (rest == deformed).all(axis=1)
        self._pixels = np.where(resting, _RESTING_RADIUS, _RADIUS)
        if hovered is not None:
            self._pixels[hovered] += _HOVER_GROWTH
        self._balls.SetPoints(polydata.points(deformed))
        arrays.add(self._balls.GetPointData(), "color", colors)
        arrays.add(self._balls.GetPointData(), "radius", np.ones(len(deformed)))
        ends = np.stack([rest[~resting], deformed[~resting]], axis=1).reshape(-1, 3)
        self._lines.SetPoints(polydata.points(ends))
        self._lines.SetLines(polydata.cells(np.arange(len(ends)).reshape(-1, 2)))

    def fit(self, projection):
        """Set the radii of the balls for a `Projection`."""
        points = self._balls.GetPoints()
        if points is None or points.GetNumberOfPoints() == 0:
            return
        radius = self._pixels * projection.pixel_size(arrays.to_numpy(points.GetData()))
        previous = arrays.to_numpy(self._balls.GetPointData().GetArray("radius"))
        if not np.allclose(previous, radius, rtol=1e-3, atol=0):
            arrays.add(self._balls.GetPointData(), "radius", radius)
            self._balls.Modified()


def _ball_actor(balls, opacity):
    sphere = configured(vtkSphereSource(), Radius=1, ThetaResolution=20, PhiResolution=14)
    mapper = configured(vtkGlyph3DMapper(), InputData=balls, ScaleArray="radius")
    mapper.SetSourceConnection(sphere.GetOutputPort())
    mapper.SetScaleModeToScaleByMagnitude()
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("color")
    mapper.SetColorModeToDirectScalars()
    actor = configured(vtkActor(), Mapper=mapper, Pickable=False)
    configured(actor.GetProperty(), Ambient=0.45, Diffuse=0.6, Specular=0.25, SpecularPower=30)
    actor.GetProperty().SetOpacity(opacity)
    return actor
