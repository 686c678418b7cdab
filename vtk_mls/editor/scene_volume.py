"""An image in the scene as a volume, and the surface that rays hit."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  renders volumes
from vtkmodules.vtkCommonCore import VTK_BIT, VTK_DOUBLE, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

from vtk_mls import Deformation
from vtk_mls.base.interpolation import sample
from vtk_mls.base.linear_algebra import unit
from vtk_mls.base.sampling import corner_median, corners_of
from vtk_mls.editor import label_picking, transfer_functions
from vtk_mls.editor.polydata import configured
from vtk_mls.files import metadata
from vtk_mls.rendering import DeformedVolume
from vtk_mls.rendering.material import material_at
from vtk_mls.rendering.volume_ray import light_along
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_STEP, _COARSE_STEP = 0.5, 1.2  # between samples along a ray, in voxels
_MAX_STEP_FACTOR = 3  # of longer steps instead of fewer rays
_SURFACE_OPACITY = 0.5  # accumulated along a ray up to the surface that the mouse picks
_MIN_OPACITY = 0.05  # of a whole ray; with less than 1, the surface is at half of it
_MAX_SAMPLES = 64  # along each axis, for the search of visible voxels


class SceneVolume:
    """A deformed image in the `Scene`, with its volume and a list of `TransferFunctionPreset`s."""

    def __init__(self, image, renderer):
        self._image, self._deformation = scalar_image(image), None
        self._grid = ImageGeometry.of_image(self._image).grid
        scalars = self._image.GetPointData().GetScalars()
        self._values = arrays.to_numpy(scalars).reshape(self._grid.shape)
        are_labels = scalars.GetName() in metadata.load(image, metadata.LABEL_ARRAYS)
        corners = [self._values[index] for index in corners_of(self._grid.shape)]
        self._background = 0 if are_labels else corner_median(corners)
        self.presets = transfer_functions.presets_of(self._values.ravel(), are_labels)
        self._mapper = configured(vtkGPUVolumeRayCastMapper(), InputData=self._image)
        configured(self._mapper, AutoAdjustSampleDistances=False, UseJittering=True)
        self.set_coarseness(1)
        self._volume = configured(vtkVolume(), Mapper=self._mapper)
        material = self._volume.GetProperty()
        material.SetScalarOpacityUnitDistance(float(np.abs(self._grid.spacing).mean()))
        configured(material, Ambient=0.35, Diffuse=0.75, Specular=0.15, SpecularPower=20)
        material.ShadeOn()
        self.set_preset(0)
        renderer.AddVolume(self._volume)
        self._deformed = DeformedVolume(self._volume, renderer)

    @property
    def preset_names(self):
        """Names (list of str) of the presets."""
        return [preset.name for preset in self.presets]

    @property
    def bounds(self):
        """Corners (2, 3) of a box around the visible voxels of the undeformed image."""
        return self._surface_of(None).bounds

    def set_preset(self, index):
        """Set colors and opacities; the name of the preset."""
        self._preset = preset = self.presets[index % len(self.presets)]
        self._limits = transfer_functions.gray_range(preset)
        colors, opacities = vtkColorTransferFunction(), vtkPiecewiseFunction()
        for node in preset.colors:
            colors.AddRGBPoint(*node)
        for node in preset.opacities:
            opacities.AddPoint(*node)
        material = configured(self._volume.GetProperty(), Color=colors, ScalarOpacity=opacities)
        if preset.is_nearest:
            material.SetInterpolationTypeToNearest()
        else:
            material.SetInterpolationTypeToLinear()
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
        """Set the pixels between rays along both axes; above 1, steps along rays are longer.

        `has_offset`: the renderer does not begin in the corner of the window. VTK 9.6 draws nothing
        there with fewer rays, so only the steps are longer.
        """
        step = _STEP if pixels <= 1 else _COARSE_STEP
        if has_offset:
            step, pixels = step * min(max(pixels, 1), _MAX_STEP_FACTOR), 1
        self._mapper.SetSampleDistance(step * float(np.abs(self._grid.spacing).min()))
        self._mapper.SetImageSampleDistance(pixels)

    def show(self, deformation, nodes, distortion, is_final):
        """Deform the volume; None for the identity."""
        self._deformation = deformation
        lines = distortion.lines if distortion.has_grid else None
        self._deformed.paint(lines, distortion.has_colors)
        if deformation is not None:
            self._deformed.update(deformation, nodes)
        elif self._deformed.uploads > 0 or lines is not None:
            # keeps the shader: to build another takes a second
            corner = self._grid.corners()[:1]
            self._deformed.update(Deformation(corner, corner), 2)

    def nearest(self, points):
        """The visible voxels of the undeformed image nearest to `points` (n, 3): (n, 3)."""
        return self._surface_of(None).nearest(points)

    def colors_at(self, points):
        """Which points (n, 3) of the deformed space have material, and their colors (n, 3).

        Other points of the image have the color of the automatic background, as when it is saved.
        """
        has_material, values = self.surface().values_at(points)
        values = np.where(has_material, values, self._background)
        colors = transfer_functions.slice_colors(self._preset, values, self._limits)
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
        """Leave the volume undeformed."""
        self._deformed.detach()

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
        ends, step = np.stack([near, far]), _STEP * spacing.min()
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

    def values_at(self, points):
        """Which points (n, 3) of the deformed space have material, and their values (n,)."""
        origins, has_material = material_at(self._deformation, points)
        index = self._grid.index_of(origins)
        method = "nearest" if self._preset.is_nearest else "linear"
        values = sample(self._values, index, method, 0, self._grid)
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


def _scalars(image):
    """The name of an array, its values (nz, ny, nx), and their VTK type."""
    data = image.GetPointData()
    candidates = [data.GetScalars(), *map(data.GetArray, range(data.GetNumberOfArrays()))]
    numeric = [array for array in candidates if array is not None and arrays.is_numeric(array)]
    if not numeric:
        raise ValueError("the image has no values at its points to show; only those of cells")
    values, vtk_type = arrays.to_numpy(numeric[0]), numeric[0].GetDataType()
    if values.ndim > 1:
        values, vtk_type = values.mean(axis=1, dtype=float), VTK_DOUBLE
    elif vtk_type == VTK_BIT:
        vtk_type = VTK_UNSIGNED_CHAR
    name = numeric[0].GetName() or "values"
    return name, values.reshape(image.GetDimensions()[::-1]), vtk_type
