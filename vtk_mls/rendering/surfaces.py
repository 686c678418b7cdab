"""Surfaces of meshes and volumes that rays meet, and the points on them nearest to others."""

from functools import cached_property

import numpy as np
from vtkmodules.vtkCommonCore import mutable, vtkIdList
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersModeling import vtkSelectEnclosedPoints

from vtk_mls.base.interpolation import sample
from vtk_mls.base.linear_algebra import unit
from vtk_mls.rendering import transfer_functions
from vtk_mls.rendering.volume_ray import light_along, material_at
from vtk_mls.vtk.objects import configured, output_of

STEP = 0.5  # between samples along a ray, in voxels
_SURFACE_OPACITY = 0.5  # accumulated along a ray up to the surface that the mouse picks
_MIN_OPACITY = 0.05  # of a whole ray; with less than 1, the surface is at half of it
_MAX_SAMPLES = 64  # along each axis, for the search of visible voxels
_TOLERANCE = 1e-6  # of ray intersections, relative to the length of the ray


class VolumeSurface:
    """The visible part of an image with values (nz, ny, nx).

    Rays and `values_at` see it deformed; `bounds` and `nearest` are those of the undeformed image.
    """

    def __init__(self, grid, values, preset, deformation=None):
        self._grid, self._values, self._preset = grid, values, preset
        self._deformation = deformation

    @cached_property
    def _visible_voxels(self):
        """Points (n, 3) of a coarse grid that are not transparent, and the largest spacing."""
        steps = [max(1, n // _MAX_SAMPLES) for n in self._grid.dimensions]
        values = self._values[tuple(slice(None, None, step) for step in steps[::-1])]
        is_visible = transfer_functions.opacity(self._preset, values.ravel()) > 0
        index = np.argwhere(is_visible.reshape(values.shape))[:, ::-1]
        return self._grid.at(index * steps), float(np.abs(self._grid.spacing * steps).max())

    @property
    def bounds(self):
        """Corners (2, 3) of a box around the visible voxels; without any, around the image."""
        points, _ = self._visible_voxels
        points = points if len(points) else self._grid.corners()
        return np.array([points.min(axis=0), points.max(axis=0)])

    def nearest(self, points):
        """The visible voxels nearest to `points` (n, 3): (n, 3); points among them stay."""
        voxels, spacing = self._visible_voxels
        if len(voxels) == 0:
            return points
        nearest = np.array(points)
        for row, point in enumerate(points):
            squares = ((voxels - point) ** 2).sum(axis=1)
            if squares.min() > spacing**2:
                nearest[row] = voxels[squares.argmin()]
        return nearest

    def hit(self, near, far):
        """Where the ray from `near` to `far` (3,) meets the surface: (fraction, point), or None."""
        spacing = np.abs(self._grid.spacing)
        ends, step = np.stack([near, far]), STEP * spacing.min()
        light = light_along(self._opacity_at, ends, self._deformed_box(), step, spacing.mean())
        if light is None:
            return None
        fractions, opacities = light[0], 1 - light[1]
        if opacities[-1] < _MIN_OPACITY:
            return None
        fraction = np.interp(min(_SURFACE_OPACITY, opacities[-1] / 2), opacities, fractions)
        return fraction, near + fraction * (far - near)

    def normal(self, point):
        """The outward unit normal (3,) at a point; None without a gradient."""
        distance = 2 * float(np.abs(self._grid.spacing).mean())
        steps = distance * np.concatenate([np.eye(3), -np.eye(3)])
        opacities = self._opacity_at(point + steps)
        slope = opacities[3:] - opacities[:3]
        return unit(slope) if slope.any() else None

    def values_at(self, points, values=None):
        """Which points (n, 3) of the deformed space have material, and their values (n,).

        Other `values` (nz, ny, nx, c) than those of the image give values (n, c).
        """
        origins, has_material = material_at(self._deformation, points)
        index = self._grid.index_of(origins)
        index[:, np.array(self._grid.dimensions) == 1] = 0  # a flat image is as thick as needed
        method = "nearest" if self._preset.is_nearest else "linear"
        values = sample(self._values if values is None else values, index, method, 0, self._grid)
        return self._grid.covers(index) & has_material, values

    def _opacity_at(self, points):
        has_material, values = self.values_at(points)
        return np.where(has_material, transfer_functions.opacity(self._preset, values), 0)

    def _deformed_box(self):
        """Corners (2, 3) of a box that contains the deformed volume."""
        corners = self._grid.corners()
        if self._deformation is not None:
            size = np.ptp(corners, axis=0).max()
            moved = self._deformation.deformed
            corners = np.vstack([corners, moved - 0.2 * size, moved + 0.2 * size])
        return np.stack([corners.min(axis=0), corners.max(axis=0)])


class SurfaceLocator:
    """Finds points on the surface of a vtkDataSet; later changes of it have no effect."""

    def __init__(self, mesh):
        self._surface = vtkPolyData()
        if not isinstance(mesh, vtkPolyData):
            mesh = output_of(vtkGeometryFilter(), InputData=mesh)
        self._surface.ShallowCopy(mesh)

    @cached_property
    def _locator(self):
        locator = configured(vtkStaticCellLocator(), DataSet=self._surface)
        locator.BuildLocator()
        return locator

    def hit(self, near, far):
        """Where the ray from `near` to `far` (3,) meets the surface: (fraction, point), or None."""
        if self._surface.GetNumberOfCells() == 0:
            return None
        fraction, point, parametric = mutable(0.0), [0.0] * 3, [0.0] * 3
        is_hit = self._locator.IntersectWithLine(
            near, far, _TOLERANCE, fraction, point, parametric, mutable(0), mutable(0)
        )
        return (float(fraction), np.array(point)) if is_hit else None

    def nearest(self, points):
        """The nearest points to `points` (n, 3): (n, 3); points in a closed surface stay."""
        surface, enclosed = self._surface, vtkSelectEnclosedPoints()
        if surface.GetNumberOfCells() == 0:
            rows = [surface.FindPoint(point) for point in points]
            return np.array([p if i < 0 else surface.GetPoint(i) for i, p in zip(rows, points)])
        is_closed = bool(enclosed.IsSurfaceClosed(surface))
        enclosed.Initialize(surface)
        nearest = np.array(points)
        for row, point in enumerate(points):
            if not (is_closed and enclosed.IsInsideSurface(*point)):
                nearest[row], _ = self._closest(point)
        enclosed.Complete()
        return nearest

    def normal(self, point):
        """The unit normal (3,) of the nearest cell; None for degenerate cells."""
        if self._surface.GetNumberOfCells() == 0:
            return None
        ids = vtkIdList()
        self._surface.GetCellPoints(self._closest(point)[1], ids)
        if ids.GetNumberOfIds() < 3:
            return None
        a, b, c = (np.array(self._surface.GetPoint(ids.GetId(i))) for i in range(3))
        normal = np.cross(b - a, c - a)
        return unit(normal) if normal.any() else None

    def _closest(self, point):
        """The closest point (3,), and the id of its cell."""
        closest, cell = [0.0] * 3, mutable(0)
        self._locator.FindClosestPoint(point, closest, cell, mutable(0), mutable(0.0))
        return closest, int(cell)
