"""The transform that moves the material before the deformation of a filter."""

from os import PathLike

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataObjectTypes

from vtk_mls import Chain
from vtk_mls.base.validation import short_repr
from vtk_mls.files.field_files import read_transform
from vtk_mls.files.paths import existing_file
from vtk_mls.filters import warping
from vtk_mls.filters.algorithm import run_all
from vtk_mls.queries.transform import Transform
from vtk_mls.vtk import arrays


def read_initial(value, cache):
    """The transform of the property InitialTransform, or None.

    `value` is a Transform or the path of a file, "" for none; `cache` a CachedValue for the last
    file. Errors name the property.
    """
    if isinstance(value, Transform):
        return value
    if not isinstance(value, (str, PathLike)):
        raise TypeError(
            "`InitialTransform` must be the path of a file, or an Affine, Field, Chain or "
            f"Deformation, got {short_repr(value)}"
        )
    if not str(value):
        return None
    try:
        path = existing_file(value)
        status = path.stat()
        return cache.of((path, status.st_mtime_ns, status.st_size), lambda: read_transform(path))
    except (OSError, ValueError) as error:
        raise ValueError(f"`InitialTransform`: {error}") from error


def split_chain(transform):
    """The initial transform or None, and the deformation, of `updated_deformation`."""
    return transform.transforms if isinstance(transform, Chain) else (None, transform)


class WarpAfter(warping.Warp):
    """The deformation of a mesh that the Transform `initial` has moved before.

    `between` is a MeshCache of the meshes that it has moved; the others are arguments of `Warp`.
    """

    def __init__(self, initial, between, *arguments):
        super().__init__(*arguments)
        self.initial, self.between, self.input = initial, between, self.mesh

    def tasks(self):
        return [self._begin, *[self._split] * self.divides, self._warp]

    def _begin(self, progress):
        """Make the mesh between both transforms."""
        # vectors are transformed by both, one after the other
        options = warping.MeshOptions(self.options.directions)

        def make():
            moved = vtkDataObjectTypes.NewDataObject(warping.output_type(self.input, False))
            warp = warping.Warp(options, warping.Blends(1.0, self.initial), self.input, moved, None)
            run_all(warp.tasks(), progress)
            return moved

        self.mesh = self.between.of(self.input, (self.initial, options), make)
        if not self.divides:
            warping.copy(self.mesh, self.output)

    def _warp(self, progress):
        self.output.GetFieldData().ShallowCopy(self.input.GetFieldData())
        points = self.output.GetPointData()
        self.earlier = arrays.to_numpy(points.GetArray("ForwardDisplacement"))
        self.was_found = arrays.to_numpy(points.GetArray("NoInverse")) == 0
        super()._warp(progress)

    def _from_rest(self, field):
        return self.earlier + field.displacement, self.was_found & field.found

    def _rest(self):
        return self.before - self.earlier

    def _jacobians(self, deformation, moved, progress):
        between = self._off_cuts(self.before)
        for part, jacobian in super()._jacobians(deformation, moved, progress):
            v = between[part]
            is_finite = np.isfinite(v).all(axis=1)
            jacobian[is_finite] = self.initial.jacobian(v[is_finite]) @ jacobian[is_finite]
            yield part, jacobian
