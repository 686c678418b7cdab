"""An image in slices."""

from functools import cached_property

import numpy as np

from vtk_mls.base.sampling import corner_median, corners_of
from vtk_mls.editor import label_picking
from vtk_mls.files import metadata
from vtk_mls.rendering import transfer_functions
from vtk_mls.rendering.surfaces import VolumeSurface
from vtk_mls.rendering.transfer_functions import colors_of, scalar_image
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


class SceneImage:
    """A deformed image in slices, and a list of `TransferFunctionPreset`s.

    That is all of a flat image, across `flat_axis` of the world; `SceneVolume` draws others in 3-D,
    where `flat_axis` is None. Without finite values, ValueError.
    """

    prop = None  # in 3-D

    def __init__(self, image):
        self._image, self._deformation = scalar_image(image), None
        self._grid = ImageGeometry.of_image(self._image).grid
        scalars = self._image.GetPointData().GetScalars()
        self._values = arrays.to_numpy(scalars).reshape(self._grid.shape)
        if not np.isfinite(self._values).any():
            raise ValueError("the image has no finite values to show")
        self._colors = colors_of(image)
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
