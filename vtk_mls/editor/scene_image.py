"""An image in slices, and the surface that rays hit."""

from functools import cached_property

import numpy as np
from vtkmodules.vtkCommonCore import VTK_BIT, VTK_DOUBLE, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.base.interpolation import sample
from vtk_mls.base.linear_algebra import unit
from vtk_mls.base.sampling import corner_median, corners_of
from vtk_mls.editor import label_picking, transfer_functions
from vtk_mls.files import metadata
from vtk_mls.rendering.material import material_at
from vtk_mls.rendering.volume_ray import light_along
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

STEP = 0.5  # between samples along a ray, in voxels
_SURFACE_OPACITY = 0.5  # accumulated along a ray up to the surface that the mouse picks
_MIN_OPACITY = 0.05  # of a whole ray; with less than 1, the surface is at half of it
_MAX_SAMPLES = 64  # along each axis, for the search of visible voxels


class SceneImage:
    """A deformed image in slices, and a list of `TransferFunctionPreset`s.

    That is all of a flat image, across `flat_axis` of the world; `SceneVolume` draws others in 3-D,
    where `flat_axis` is None. Without finite values, ValueError.
    """

    def __init__(self, image):
        self._image, self._deformation = scalar_image(image), None
        self._grid = ImageGeometry.of_image(self._image).grid
        scalars = self._image.GetPointData().GetScalars()
        self._values = arrays.to_numpy(scalars).reshape(self._grid.shape)
        if not np.isfinite(self._values).any():
            raise ValueError("the image has no finite values to show")
        self._colors = _colors_of(image)
        flat = [axis for axis in (2, 1, 0) if self._grid.dimensions[axis] == 1]
        is_aligned = (self._grid.direction == np.eye(3)).all()
        self.flat_axis = flat[0] if flat and is_aligned else None
        is_declared = scalars.GetName() in metadata.load(image, metadata.LABEL_ARRAYS)
        are_labels = is_declared or (
            self._colors is None and label_picking.are_regions(self._values)
        )
        corners = [self._values[index] for index in corners_of(self._grid.shape)]
        self._background = 0 if are_labels else corner_median(corners)
        self.presets = transfer_functions.presets_of(self._values.ravel(), are_labels)
        if are_labels and not is_declared:
            self.presets += transfer_functions.presets_of(self._values.ravel(), False)
        if self.flat_axis is not None and not are_labels:
            self.presets = self.presets[-1:]  # gray: no others differ in slices
        SceneImage.set_preset(self, 0)  # a volume is not drawn yet

    @property
    def preset_names(self):
        """Names (list of str) of the presets."""
        return [preset.name for preset in self.presets]

    @property
    def bounds(self):
        """Corners (2, 3) of a box around the visible voxels of the undeformed image."""
        if self.flat_axis is None:
            return self._surface_of(None).bounds
        size = np.array(self._grid.dimensions)
        half = np.where(np.arange(3) == self.flat_axis, 0, 0.5)
        return self._grid.at(np.stack([-half, size - 1 + half]))

    def set_preset(self, index):
        """Set colors and opacities; the name of the preset."""
        self._preset = preset = self.presets[index % len(self.presets)]
        if self._colors is not None:
            self._limits = 0.0, 255.0
        elif self.flat_axis is not None:
            self._limits = transfer_functions.value_range(self._values)
        else:
            self._limits = transfer_functions.gray_range(preset)
        return preset.name

    def adjust(self, brightness, contrast):
        """Change the gray values of slices.

        `brightness` is added, relative to the range from black to white; `contrast` is a factor of
        the slope.
        """
        low, high = self._limits
        middle, half = (low + high) / 2 - brightness * (high - low), (high - low) / (2 * contrast)
        self._limits = middle - half, middle + half

    def set_coarseness(self, pixels, has_offset=False):
        """Nothing changes: slices cast no rays."""

    def show(self, deformation, nodes, distortion, is_final):
        """Deform the image; None for the identity."""
        self._deformation = deformation

    def nearest(self, points):
        """The visible voxels of the undeformed image nearest to `points` (n, 3): (n, 3).

        Points of a flat image stay.
        """
        if self.flat_axis is not None:
            return points
        return self._surface_of(None).nearest(points)

    def colors_at(self, points):
        """Which points (n, 3) of the deformed space have material, and their colors (n, 3).

        Other points of the image have the color of the automatic background, as when it is saved.
        """
        surface = self.surface()
        if self._colors is None:
            has_material, values = surface.values_at(points)
            values = np.where(has_material, values, self._background)
            colors = transfer_functions.slice_colors(self._preset, values, self._limits)
        else:
            has_material, values = surface.values_at(points, self._colors)
            colors = transfer_functions.shades(values * has_material[:, None], self._limits)
        colors[~has_material & ~self._grid.covers(self._grid.index_of(points))] = 0
        return has_material, colors

    def mesh(self):
        """None: slices show images by their colors."""

    def surface(self):
        """The `VolumeSurface` of the deformed volume."""
        return self._surface_of(self._deformation)

    def rigid_hit(self, near, far):
        """Fraction of a ray at a segment, and a function that returns its Shape; or None.

        None also for images without labels.
        """
        if not self._are_labels:
            return None
        values = self._grid, self._values, self._deformation
        hit = label_picking.label_on_ray(*values, near, far)
        if hit is None:
            return None
        return hit[0], lambda: label_picking.connected_label(self._image, self._grid, hit[1])

    @cached_property
    def _are_labels(self):
        return self.presets[0].is_nearest or label_picking.are_labels(self._values)

    def detach(self):
        """Nothing is drawn in 3-D."""

    def _surface_of(self, deformation):
        return VolumeSurface(self._grid, self._values, self._preset, deformation)


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


def _colors_of(image):
    """Colors (nz, ny, nx, 3), 0 to 255, along axes of the world; None for other values."""
    _, array = _numeric_array(image)
    values = arrays.to_numpy(array)
    if values.ndim == 1 or values.dtype != np.uint8 or values.shape[1] not in (3, 4):
        return None
    _, reorder = arrays.along_world_axes(ImageGeometry.of_image(image).grid)
    return reorder(values[:, :3].reshape(*image.GetDimensions()[::-1], 3))


def scalar_image(image):
    """A copy of a vtkImageData with one scalar per point and axes along those of the world.

    The scalars are the active ones, or the first array; the mean of several components. Axes are
    permuted and mirrored, as VTK 9.7 lights volumes without their direction matrix: if that mirrors
    axes, as in most NIfTI files, surfaces towards the light are dark. Without numbers at its
    points, ValueError.
    """
    name, values, vtk_type = _scalars(image)
    grid, reorder = arrays.along_world_axes(ImageGeometry.of_image(image).grid)
    copy = vtkImageData()
    ImageGeometry.of_grid(grid).apply_to(copy)
    scalars = arrays.from_numpy(np.ascontiguousarray(reorder(values)).ravel(), vtk_type)
    scalars.SetName(name)
    copy.GetPointData().SetScalars(scalars)
    return copy


def _numeric_array(image):
    """The name of the active scalars, or of the first array, and the array."""
    data = image.GetPointData()
    candidates = [data.GetScalars(), *map(data.GetArray, range(data.GetNumberOfArrays()))]
    numeric = [array for array in candidates if array is not None and arrays.is_numeric(array)]
    if not numeric:
        raise ValueError("the image has no values at its points to show; only those of cells")
    return numeric[0].GetName() or "values", numeric[0]


def _scalars(image):
    """The name of an array, its values (nz, ny, nx), and their VTK type."""
    name, array = _numeric_array(image)
    values, vtk_type = arrays.to_numpy(array), array.GetDataType()
    if values.ndim > 1:
        values, vtk_type = values.mean(axis=1, dtype=float), VTK_DOUBLE
    elif vtk_type == VTK_BIT:
        vtk_type = VTK_UNSIGNED_CHAR
    return name, values.reshape(image.GetDimensions()[::-1]), vtk_type
