"""Images, resampled backward."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from vtk_mls.base import buffer_pool, interpolation
from vtk_mls.files import provenance
from vtk_mls.filters import gradients, void_arrays
from vtk_mls.filters.algorithm import run_all
from vtk_mls.filters.extents import of_cells
from vtk_mls.vtk import arrays


class Resampling:
    """What is done to one image, or to one part of it.

    Parameters
    ----------
    wanted : MLSDeform
        Says how arrays are sampled and which are to be made.
    deformation : Deformation
    image, output : vtkImageData
        The output lies where its points are wanted; it is filled.
    sampling : Sampling
        From the grid of the image to that of the output.
    """

    def __init__(self, wanted, deformation, image, output, sampling):
        self.wanted, self.deformation = wanted, deformation
        self.image, self.output = image, output
        self.sampling, self.target = sampling, sampling.target
        # at the points of the target, once they are mapped
        self._void_distance = self._gradient = None
        self._scalars = self._scalars_of_gradient()
        self.labels = {*wanted.GetLabelArrays(), *provenance.kept(image, provenance.LABEL_ARRAYS)}

    def tasks(self):
        """Functions of a Progress, in their order."""
        tasks = [
            partial(self._resample, old, new, sampling)
            for old, new, sampling in (
                (self.image.GetPointData(), self.output.GetPointData(), self.sampling),
                (self.image.GetCellData(), self.output.GetCellData(), of_cells(self.sampling)),
            )
            if old.GetNumberOfArrays() > 0
        ]
        if self.deformation.cuts:
            tasks.append(self._mark_void)
        if self._scalars is not None:
            tasks.append(self._add_gradient)
        return tasks

    def _scalars_of_gradient(self):
        """The values (nz, ny, nx) whose gradient is wanted; None if none is."""
        name = self.wanted.GetGradientArray()
        # another block may have it
        has_it = self.image.GetPointData().HasArray(name) or not self.wanted.is_among_blocks()
        return gradients.scalars(self.image, name) if name and has_it else None

    def _resample(self, old, new, sampling, progress):
        """Deform the arrays `old` into `new`, those with the same background in one pass."""
        values = arrays.image_values(old, sampling.source)
        results, passes, tasks, dtypes = [None] * len(values), {}, [], {}

        with_gradient = sampling is self.sampling and self._scalars is not None

        def fill(background, members, progress):
            chosen = [values[number] for number, _ in members]
            methods = [method for _, method in members]
            versions = [self._version(old.GetAbstractArray(number)) for number, _ in members]
            how = replace(sampling, interpolation=methods, background=background, versions=versions)
            void_distance = self._new_void_distance(sampling)
            if with_gradient and np.array_equal(background, sampling.background, equal_nan=True):
                done, self._gradient = self.deformation.resample_with_gradient(
                    chosen,
                    self._scalars,
                    replace(how, interpolation=[*methods, sampling.interpolation]),
                    self.wanted.GetNormalizeGradient(),
                    progress,
                    void_distance,
                )
            else:
                done = self.deformation.resample(chosen, how, progress, void_distance)
            for (number, _), result in zip(members, done):
                results[number] = result

        def transform(number, how, progress):
            vectors = values[number]
            if how == "tangent":
                result = self.deformation.resample_vectors(vectors, sampling, progress)
            else:
                unit = how == "normal" or self.wanted.GetNormalizeGradient()
                result = self.deformation.resample_gradients(vectors, sampling, unit, progress)
            results[number] = result.astype(vectors.dtype)

        directions = gradients.directions(
            old, self.wanted.GetGradientVectorArrays(), self.wanted.GetPushForwardArrays()
        )
        for number in range(len(values)):
            array = old.GetAbstractArray(number)
            if array.GetName() in directions:
                tasks.append(partial(transform, number, directions[array.GetName()]))
            else:
                method, background = self._method(array)
                if background is None:
                    background, dtype = sampling.background, values[number].dtype
                    dtypes[f"array `{array.GetName()}`"] = dtype
                    if not interpolation.is_in_range(background, dtype):
                        background = interpolation.cast(background, dtype).item()
                passes.setdefault(background, []).append((number, method))
        sampling.warn_of_background(dtypes)
        if with_gradient:
            passes.setdefault(sampling.background, [])
        tasks += [partial(fill, background, members) for background, members in passes.items()]
        run_all(tasks, progress)
        arrays.set_image_values(new, results, old)

    def _version(self, array):
        """What tells the contents of an image's array from all others, or None."""
        if not self.wanted.keeps_images:
            return None
        # of the image, too: who writes into an array need not say so to the array itself
        return array.__this__, array.GetMTime(), self.image.GetMTime()

    def _method(self, array):
        """Interpolation and background of an array; None for that of the sampling."""
        if not arrays.is_numeric(array):
            return "nearest", -1
        if array.GetName() == arrays.GHOSTS:
            return "nearest", 0.0
        if array.__this__ in self.wanted.flags:
            return "nearest", float(abs(self.sampling.background) > 0)
        if array.GetName() in self.labels:
            return "nearest", None
        return self.sampling.interpolation, None

    def _mark_void(self, progress):
        """Make what tells of the void: at points, then in cells."""
        run_all([self._mark_points, self._mark_cells], progress)

    def _new_void_distance(self, sampling):
        """An array for void distances at the points of the target, if there is none yet."""
        is_wanted = sampling is self.sampling and self.deformation.cuts
        if not is_wanted or self._void_distance is not None:
            return None
        self._void_distance = buffer_pool.empty(self.target.shape, np.float32)
        return self._void_distance

    def _mark_points(self, progress):
        if self._void_distance is None:
            self._void_distance = self.deformation.void_distance_field(self.target, progress)
        data = self.output.GetPointData()
        void_arrays.add_void(data, self._void_distance)
        if self.wanted.GetHideVoid():
            void_arrays.hide(data, arrays.to_numpy(data.GetArray("Void")))

    def _mark_cells(self, progress):
        data = self.output.GetCellData()
        void_distance, self._void_distance = self._void_distance, None
        void = self.deformation.void_of_cells(self.target, void_distance, progress)
        arrays.add(data, "Void", void.at_centre.ravel())
        if self.wanted.GetHideVoid() and void_arrays.CAN_HIDE_CELLS:
            void_arrays.hide(data, void.at_centre | void.touched)

    def _add_gradient(self, progress):
        """Add "Gradient" of point scalars."""
        progress.report(0)
        gradients.add_gradient(self.output, self._gradient)
