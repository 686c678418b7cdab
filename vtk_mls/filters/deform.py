"""Deform an image."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline

from vtk_mls import INTERPOLATIONS, Grid, arrays
from vtk_mls.arrays import Lattice
from vtk_mls.filters.algorithm import numbers
from vtk_mls.filters.deforming import DeformingFilter


class MLSDeform(DeformingFilter):
    """Deforms an image by control points.

    On input port 0 is the image, on port 1 are the control points (see `DeformingFilter`). Each
    execution resamples every point and cell array backward: the value at a place is the input's
    at where its material came from (G, Eq. 2 of the paper). Arrays keep type, names and role;
    integers are rounded; strings come from the nearest point, and so do label arrays and
    `vtkGhostType`. Field data passes. Where G is the identity, values are the same to the bit.

    The whole input is needed whatever part of the output is asked for; memory is that of input
    and output. Pieces of the output are made independently, so MPI processes share the work.

    Properties
    ----------
    Kind, Alpha, Degree, Device
        See `DeformingFilter`.
    Interpolation : {"linear", "nearest", "cubic"}
    Background : float
        Value of places whose material came from outside of the input; 0 in `vtkGhostType`.
    LabelArrays : names
        Of point and cell arrays whose values must not mix.
    OutputGrid : {"input", "fitted", "given"}
        The input's points; its lattice, as far as the deformed volume reaches; or
        OutputDimensions points at OutputSpacing from OutputOrigin on, in the input's directions.
        For "fitted" the control points are updated in RequestInformation.
    """

    def __init__(self):
        super().__init__("vtkImageData")
        self._interpolation = "linear"
        self._background = 0.0
        self._label_arrays = ()
        self._output_grid = "input"
        self._output_dimensions = (64, 64, 64)
        self._output_spacing = (1.0, 1.0, 1.0)
        self._output_origin = (0.0, 0.0, 0.0)
        self._fit = None  # deformation and input lattice of the last fitted grid, and that grid

    def SetInterpolation(self, interpolation):
        """One of `vtk_mls.INTERPOLATIONS`."""
        self._set("_interpolation", interpolation)

    def GetInterpolation(self):
        return self._interpolation

    def SetBackground(self, value):
        """Value outside of the material."""
        self._set("_background", value)

    def GetBackground(self):
        return self._background

    def AddLabelArray(self, name):
        """Name of a point or cell array that is sampled nearest."""
        if name not in self._label_arrays:
            self._set("_label_arrays", (*self._label_arrays, name))

    def ClearLabelArrays(self):
        self._set("_label_arrays", ())

    def GetLabelArrays(self):
        return self._label_arrays

    def SetOutputGrid(self, choice):
        """ "input", "fitted" or "given"."""
        self._set("_output_grid", choice)

    def GetOutputGrid(self):
        return self._output_grid

    def SetOutputDimensions(self, *dimensions):
        """Numbers of points (nx, ny, nz) of the given grid."""
        self._set("_output_dimensions", numbers(dimensions))

    def GetOutputDimensions(self):
        return self._output_dimensions

    def SetOutputSpacing(self, *spacing):
        """Distances of points of the given grid, world units."""
        self._set("_output_spacing", numbers(spacing))

    def GetOutputSpacing(self):
        return self._output_spacing

    def SetOutputOrigin(self, *origin):
        """First point of the given grid, world coordinates."""
        self._set("_output_origin", numbers(origin))

    def GetOutputOrigin(self):
        return self._output_origin

    def RequestInformation(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        info.Set(vtkAlgorithm.CAN_PRODUCE_SUB_EXTENT(), 1)
        lattice = Lattice.of_information(inInfo[0].GetInformationObject(0))
        try:
            points = self._update_input(1) if self._output_grid == "fitted" else None
            lattice = self._output_lattice(lattice, points)
        except (TypeError, ValueError, RuntimeError):
            pass  # RequestData meets the same and reports it
        lattice.announce(info)
        return 1

    def RequestData(self, request, inInfo, outInfo):
        image = vtkImageData.GetData(inInfo[0])
        points = vtkPolyData.GetData(inInfo[1])
        output = vtkImageData.GetData(outInfo)
        lattice = Lattice.of_image(image)
        if lattice.is_empty:
            raise ValueError("`Input` is an empty image; it must have at least one point")
        if self._interpolation not in INTERPOLATIONS:
            raise ValueError(
                f"`interpolation` must be one of {', '.join(INTERPOLATIONS)}, "
                f"got {self._interpolation!r}"
            )
        self._check_labels(image)
        deformation = self._deformation(points)
        announced = (
            inInfo[0].GetInformationObject(0).Get(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT())
        )
        target = self._output_lattice(lattice.part(announced or lattice.extent), points)
        target = self._requested_part(target, outInfo.GetInformationObject(0))
        target.place(output)
        cells = arrays.cell_grid(lattice.grid), arrays.cell_grid(target.grid)
        jobs = [
            (image.GetPointData(), output.GetPointData(), lattice.grid, target.grid),
            (image.GetCellData(), output.GetCellData(), *cells),
        ]
        jobs = [job for job in jobs if job[0].GetNumberOfArrays() > 0]
        for number, (old, new, source, grid) in enumerate(jobs):
            report = self._progress(number / len(jobs), 1 / len(jobs))
            self._resample(deformation, old, new, source, grid, report)
        return 1

    def _resample(self, deformation, old, new, source, target, progress):
        """Deform the arrays `old` into `new`, those with the same background in one pass."""
        values = arrays.image_values(old, source)
        results, passes = [None] * len(values), {}
        for number in range(len(values)):
            array = old.GetAbstractArray(number)
            method, background = self._interpolation, self._background
            if not arrays.is_numeric(array):
                method, background = "nearest", -1
            elif array.GetName() == arrays.GHOSTS:
                method, background = "nearest", 0.0
            elif array.GetName() in self._label_arrays:
                method = "nearest"
            passes.setdefault(background, []).append((number, method))
        for turn, (background, members) in enumerate(passes.items()):
            chosen, methods = zip(*members)
            done = deformation.resample(
                [values[number] for number in chosen],
                source,
                target,
                list(methods),
                background,
                lambda fraction, turn=turn: progress((turn + fraction) / len(passes)),
            )
            for number, result in zip(chosen, done):
                results[number] = result
        arrays.set_image_values(new, results, old)

    def _output_lattice(self, source, points):
        """Where the whole output lies, for an input on `source`."""
        if self._output_grid == "input":
            return source
        if self._output_grid == "fitted":
            deformation = self._deformation(points)
            if self._fit is None or self._fit[:2] != (deformation, source):
                grid = deformation.fitted_grid(source.grid)
                self._fit = deformation, source, Lattice.of_grid(grid)
            return self._fit[2]
        if self._output_grid == "given":
            direction = np.reshape(source.direction, (3, 3))
            try:
                grid = Grid(
                    self._output_dimensions, self._output_origin, self._output_spacing, direction
                )
            except (TypeError, ValueError) as error:
                raise ValueError(f"the given output grid is not one: {error}") from error
            return Lattice.of_grid(grid)
        raise ValueError(
            f"`OutputGrid` must be one of input, fitted, given, got {self._output_grid!r}"
        )

    def _requested_part(self, target, info):
        """The part of the output that downstream asks for, if it knows where the output is."""
        extent = info.Get(vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT())
        announced = Lattice.of_information(info)
        if announced.part(()) == target.part(()) and target.holds(extent):
            return target.part(extent)
        return target

    def _check_labels(self, image):
        data = image.GetPointData(), image.GetCellData()
        for name in self._label_arrays:
            if not any(attributes.HasArray(name) for attributes in data):
                there = [a.GetArrayName(i) for a in data for i in range(a.GetNumberOfArrays())]
                raise ValueError(
                    f"`LabelArrays` names `{name}`, which the input has not; it has "
                    f"{', '.join(f'`{name}`' for name in there) or 'no arrays'}"
                )
