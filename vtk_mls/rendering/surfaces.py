"""Surfaces of meshes, volumes and views that rays meet, and points on them nearest to others."""

from functools import cached_property

import numpy as np
from vtkmodules.vtkCommonCore import mutable, vtkCommand, vtkFloatArray, vtkIdList
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersModeling import vtkSelectEnclosedPoints
from vtkmodules.vtkRenderingVolume import vtkVolumeMapper

from vtk_mls.base.interpolation import sample
from vtk_mls.base.linear_algebra import unit
from vtk_mls.files.block_files import leaves
from vtk_mls.filters.control_point_source import lattice
from vtk_mls.rendering import deformed_volume, transfer_functions
from vtk_mls.rendering.projection import Projection
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of, shallow_copy
from vtk_mls.vtk.transforms import matrix_of

STEP, _MAX_STEPS = 0.5, 2000  # between samples along a ray, in voxels; number of them
_SURFACE_OPACITY = 0.5  # accumulated along a ray up to the surface that the mouse picks
_MIN_OPACITY = 0.05  # of a whole ray; with less than 1, the surface is at half of it
_MAX_SAMPLES = 64  # along each axis, for the search of visible voxels
_MIN_DISTANCE = 0.2  # between first handles, relative to the steps of their lattice
_MIN_STEP = 0.05  # of a lattice along an axis of flat data, relative to the longest step
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
        if not isinstance(mesh, vtkPolyData):
            mesh = output_of(vtkGeometryFilter(), InputData=mesh)
        self._surface = shallow_copy(mesh)

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


def opaque_at(volume, start, end):
    """Where a ray becomes half opaque, in VTK's composite blending.

    The fraction of the ray from `start` to `end`, world coordinates; None if it does not become
    opaque, as with other blend modes, and for volumes that are no images.
    """
    mapper, image, deformation = _drawn(volume)
    if image is None or mapper.GetBlendMode() != vtkVolumeMapper.COMPOSITE_BLEND:
        return None
    array, is_cell_data = deformed_volume.scalars_of(mapper, image)
    if array is None:
        return None
    grid = arrays.ImageGeometry.of_image(image).grid
    grid = grid.cells if is_cell_data else grid
    values = arrays.to_numpy(array).reshape(*grid.shape, -1)[..., -1]  # that give the opacity
    to_data = np.linalg.inv(matrix_of(volume.GetMatrix()))
    ends = np.stack([start, end]) @ to_data[:3, :3].T + to_data[:3, 3]
    function = volume.GetProperty().GetScalarOpacity(0)
    unit_distance = volume.GetProperty().GetScalarOpacityUnitDistance(0)

    def opacity_at(points):
        origins, has_material = material_at(deformation, points)
        index = grid.index_of(origins)
        inside = grid.covers(index) & has_material
        samples = sample(values, index[inside], "linear", 0, grid)
        opacity = np.zeros(len(points))
        opacity[inside] = [function.GetValue(value) for value in samples.ravel().tolist()]
        return opacity

    step, corners = STEP * min(grid.spacing), _corners(grid, deformation)
    light = light_along(opacity_at, ends, corners, step, unit_distance)
    if light is None:
        return None
    t, transmitted = light
    is_opaque = transmitted[-1] <= 1 - _SURFACE_OPACITY
    return np.interp(_SURFACE_OPACITY, 1 - transmitted, t) if is_opaque else None


def light_along(opacity_at, ends, corners, step, unit):
    """Transmitted light along a ray: fractions of the ray (n,), and the light there (n,) from 1 on.

    `opacity_at(points)` is per `unit` of distance, `ends` (2, 3) are those of the ray, and
    `corners` (2, 3) those of the box that contains the volume. Samples are `step` apart, or more if
    there would be too many. None if the ray misses the box.
    """
    near, far = _passage(ends, corners)
    length = np.linalg.norm(ends[1] - ends[0])
    count = int(np.clip((far - near) * length / step, 0, _MAX_STEPS))
    if count == 0:
        return None
    t = np.linspace(near, far, count + 1)
    middles = (t[1:] + t[:-1]) / 2
    opacity = opacity_at(ends[0] + middles[:, None] * (ends[1] - ends[0]))
    transmitted = (1 - np.clip(opacity, 0, 1)) ** ((far - near) * length / count / unit)
    return t, np.cumprod([1, *transmitted])


def _drawn(volume):
    """The mapper of a volume, its image or None, and its Deformation or None."""
    mapper = volume.GetMapper()
    if drawn := deformed_volume.drawn_as(volume):
        return mapper, *drawn
    data = mapper.GetDataObjectInput() if isinstance(mapper, vtkVolumeMapper) else None
    if data is not None:  # the first block, if there are several
        data = next(iter(leaves(data)), None)
    return mapper, data if isinstance(data, vtkImageData) else None, None


def _corners(grid, deformation):
    corners = grid.corners()
    if deformation is None:
        return np.stack([corners.min(axis=0), corners.max(axis=0)])
    corners = np.concatenate([corners, deformation.handle_set.positions[1]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    return np.stack([low - (high - low), high + (high - low)])


def _passage(ends, corners):
    """The fractions at which a ray enters and leaves a box."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (corners - ends[0]) / (ends[1] - ends[0])
    near, far = np.nanmax(t.min(axis=0)), np.nanmin(t.max(axis=0))
    return max(near, 0.0), max(min(far, 1.0), max(near, 0.0))


def material_at(deformation, points):
    """Origins of `points` (m, 3), world coordinates, and which of them have material: (m,) bool.

    They have none in voids between the faces of cuts. The Deformation None is the identity.
    """
    if deformation is None:
        return points, np.ones(len(points), bool)
    has_material = ~deformation.void(points) if deformation.cuts else np.ones(len(points), bool)
    return deformation.backward(points), has_material


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


def handles_on(items, bounds, count):
    """First handles: points (n, 3) of a lattice; those outside the data move to the nearest there.

    `items` have a method `nearest`, `bounds` (2, 3) are corners of the lattice, and `count` is the
    number of points along each axis. Flat or narrow data get fewer points.
    """
    nodes = lattice((count,) * 3, bounds.T.ravel())
    nearest = np.stack([item.nearest(nodes) for item in items])
    distances = np.linalg.norm(nearest - nodes, axis=2)
    points = nearest[distances.argmin(axis=0), np.arange(len(nodes))]
    steps = np.ptp(bounds, axis=0) / (count - 1)
    scaled = points / np.maximum(steps, _MIN_STEP * (steps.max() or 1.0))
    rows = [0]
    for row, point in enumerate(scaled):
        if np.linalg.norm(scaled[rows] - point, axis=1).min() > _MIN_DISTANCE:
            rows.append(row)
    return points[rows]
