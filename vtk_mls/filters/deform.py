"""Deform an image or a mesh."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from vtkmodules.vtkCommonDataModel import (
    vtkDataObject,
    vtkDataObjectTypes,
    vtkDataSet,
    vtkImageData,
)
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline

from vtk_mls import INTERPOLATIONS, VOID_VALUES, Grid, Sampling, arrays
from vtk_mls.arrays import ImageGeometry
from vtk_mls.filters import extents, warping
from vtk_mls.filters.algorithm import (
    ask_for_all,
    ask_for_extent,
    ask_within_the_whole,
    numbers,
)
from vtk_mls.filters.deforming import DeformingFilter
from vtk_mls.filters.resampling import Resampling
from vtk_mls.reals import shown


class MLSDeform(DeformingFilter):
    """Deforms an image or a mesh by control points.

    On input port 0 is the dataset, on port 1 may be control points, on port 2 cuts (see
    `DeformingFilter`). Composite data are deformed block by block. Field data pass.

    Images are resampled backward: the value at a place is the input's at where its material came
    from (G, Eq. 2 of the paper). Point and cell arrays keep type, names and role; integers are
    rounded; strings come from the nearest point, and so do label arrays and `vtkGhostType`. Where G
    is the identity, values are the same to the bit.

    Points of meshes are moved forward, by the exact inverse of G, so that a mesh and an image
    deformed alike stay together. The output has the type of the input, but vtkRectilinearGrid
    becomes vtkStructuredGrid. All arrays are kept, and "ForwardDisplacement" is the way of each
    point. Where there is no inverse (the map folds, or what is there was pushed through a cut; a
    point is NaN) "NoInverse" is 1, the point goes to the nearest place that was found, and the
    field array "FailedInverses" counts.

    Directions turn: gradients as J_G^T (Eq. 29), namely the active normals, which keep length 1,
    and the GradientVectorArrays; the PushForwardArrays as J_G^-1. In images they are 0 in the void
    and outside.

    With cuts, points of images have "Void" and "VoidDistance", cells "Void" (at their centre), and
    `vtkGhostType` hides the void: its points, and the cells that it fills or touches. VTK's
    surfaces, slices, thresholds and volume rendering leave these out. (vtkContourFilter does not
    look at ghosts of images.) To clip or contour smoothly by VoidDistance turn HideVoid off, for
    cells on the face must be there for that, and set VoidValues to "continued". Before VTK 9.3,
    in whose vtkGeometryFilter hidden cells of images are a crash, only points are hidden: there a
    threshold by Void leaves it out. Cells of meshes are split along cuts (see `splitting`); types
    that cannot hold the pieces become vtkUnstructuredGrid.

    Memory is that of input and output. Pieces of the output are made independently, so MPI
    processes share the work; those of images are, put together, the whole to the bit. For a piece
    just the extent of the input image that it needs is asked for; to know it, control points and
    cuts are updated in RequestUpdateExtent, and the map is evaluated once more.

    Properties
    ----------
    Kind, Alpha, Degree, Device, Nu, CutType, CutOrigin, CutNormal, CutInward, GenerateJacobian,
    GenerateJacobianDeterminant
        See `DeformingFilter`.
    Interpolation : {"linear", "nearest", "cubic"}
    Background : float
        Value of places whose material came from outside of the input, and of the void; 0 in
        `vtkGhostType`.
    LabelArrays : names
        Of point and cell arrays whose values must not mix, beside those that the input itself
        names in its field data "LabelArrays", as the images of segmentations do that `io` reads.
    OutputGrid : {"input", "fitted", "given"}
        The input's points; its lattice, as far as the deformed volume reaches; or
        OutputDimensions points at OutputSpacing from OutputOrigin on, in the input's directions.
        For "fitted" control points and cuts are updated in RequestInformation.
    HideVoid : bool
        Whether `vtkGhostType` hides the void.
    VoidValues : {"background", "continued"}
        What arrays hold in the void: Background; or what they would if the material of each side
        went on behind the face. Then contour or slice first and clip by VoidDistance after: the
        result ends at the face without steps, and in its unmixed colours.
    GradientArray : name
        Of the point scalars whose gradient in the deformed image is wanted, as point array
        "Gradient" (three floats, per world unit): J_G^T (grad f)(G(v)), and across the face on
        the face of the void unless values are continued behind it. "" for none.
    GradientVectorArrays : names
        Of point and cell arrays that are gradients of the input.
    NormalizeGradient : bool
        Whether "Gradient" and the GradientVectorArrays get length 1.
    PushForwardArrays : names
        Of point and cell arrays of vectors that move with the material, as velocities do.
    SplitCells : bool
        Whether cells of meshes are split along cuts. Otherwise those that are torn have "Void" 1
        and are hidden by `vtkGhostType`.
    """

    def __init__(self):
        # not vtkDataSet, which ParaView's GUI would try to make
        super().__init__(output_type="vtkDataObject")
        self._interpolation = "linear"
        self._background = 0.0
        self._label_arrays = ()
        self._output_grid = "input"
        self._output_dimensions = (64, 64, 64)
        self._output_spacing = (1.0, 1.0, 1.0)
        self._output_origin = (0.0, 0.0, 0.0)
        self._hides_void = True
        self._void_values = "background"
        self._gradient_array = ""
        self._gradient_vector_arrays = ()
        self._normalizes_gradient = False
        self._push_forward_arrays = ()
        self._splits_cells = True
        self._splits = warping.Splits()
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

    def SetHideVoid(self, wanted):
        """Whether `vtkGhostType` hides the void."""
        self._set("_hides_void", bool(wanted))

    def GetHideVoid(self):
        return self._hides_void

    def SetVoidValues(self, choice):
        """One of `vtk_mls.VOID_VALUES`."""
        self._set("_void_values", choice)

    def GetVoidValues(self):
        return self._void_values

    def SetGradientArray(self, name):
        """Name of point scalars whose gradient is wanted, "" for none."""
        self._set("_gradient_array", name or "")

    def GetGradientArray(self):
        return self._gradient_array

    def AddGradientVectorArray(self, name):
        """Name of a point or cell array of the input that is a gradient."""
        if name not in self._gradient_vector_arrays:
            self._set("_gradient_vector_arrays", (*self._gradient_vector_arrays, name))

    def ClearGradientVectorArrays(self):
        self._set("_gradient_vector_arrays", ())

    def GetGradientVectorArrays(self):
        return self._gradient_vector_arrays

    def SetNormalizeGradient(self, wanted):
        """Whether gradients get length 1."""
        self._set("_normalizes_gradient", bool(wanted))

    def GetNormalizeGradient(self):
        return self._normalizes_gradient

    def AddPushForwardArray(self, name):
        """Name of a point or cell array of vectors that move with the material."""
        if name not in self._push_forward_arrays:
            self._set("_push_forward_arrays", (*self._push_forward_arrays, name))

    def ClearPushForwardArrays(self):
        self._set("_push_forward_arrays", ())

    def GetPushForwardArrays(self):
        return self._push_forward_arrays

    def SetSplitCells(self, wanted):
        """Whether cells of a mesh that a cut crosses are divided along it."""
        self._set("_splits_cells", bool(wanted))

    def GetSplitCells(self):
        return self._splits_cells

    def RequestDataObject(self, request, inInfo, outInfo):
        data = vtkDataObject.GetData(inInfo[0])
        if not isinstance(data, vtkDataSet):
            return 1  # composite: VTK asks again for each block
        if isinstance(data, vtkImageData):
            wanted = "vtkImageData"
        else:
            wanted = warping.output_type(data, self._splits_cells and self._has_cuts())
        output = vtkDataObject.GetData(outInfo)
        if output is None or output.GetClassName() != wanted:
            is_same = data.GetClassName() == wanted
            output = data.NewInstance() if is_same else vtkDataObjectTypes.NewDataObject(wanted)
            outInfo.GetInformationObject(0).Set(vtkDataObject.DATA_OBJECT(), output)
        return 1

    def RequestInformation(self, request, inInfo, outInfo):
        if not isinstance(vtkDataObject.GetData(inInfo[0]), vtkImageData):
            return 1
        info = outInfo.GetInformationObject(0)
        info.Set(vtkAlgorithm.CAN_PRODUCE_SUB_EXTENT(), 1)
        geometry = ImageGeometry.of_information(inInfo[0].GetInformationObject(0))
        # RequestData meets the same errors and reports them
        with suppress(TypeError, ValueError, RuntimeError):
            geometry = self._output_geometry(geometry, self._updated_deformation)
        geometry.announce(info)
        return 1

    def RequestUpdateExtent(self, request, inInfo, outInfo):
        super().RequestUpdateExtent(request, inInfo, outInfo)
        if isinstance(vtkDataObject.GetData(inInfo[0]), vtkImageData):
            self._ask_for_image(inInfo, outInfo)
        else:  # a mesh is deformed piece by piece, as it comes
            ask_within_the_whole(inInfo[0].GetInformationObject(0))
        return 1

    def _ask_for_image(self, inInfo, outInfo):
        """Ask for all of the input image, or for what a part of the output needs."""
        info, asked = inInfo[0].GetInformationObject(0), outInfo.GetInformationObject(0)
        ask_for_all(info)
        source = ImageGeometry.of_information(info)
        # RequestData meets the same errors and reports them
        with suppress(TypeError, ValueError, RuntimeError):
            whole = self._output_geometry(source, lambda: self._updated_deformation(asked))
            target = self._requested_part(whole, asked)
            if target == whole or source.is_empty:
                return
            ask_for_extent(info, extents.first_cell(source))
            if not target.is_empty:
                more = extents.GRADIENT_REACH if self._gradient_array else 0
                deformation = self._updated_deformation(asked)
                sampling = self._sampling(source.grid, target.grid_within(whole))
                extent = extents.needed_extent(deformation, source, sampling, more)
                ask_for_extent(info, extent)

    def RequestData(self, request, inInfo, outInfo):
        data = vtkDataSet.GetData(inInfo[0])
        self._check(data)
        deform = self._deform_image if isinstance(data, vtkImageData) else self._deform_mesh
        self._run(deform(data, inInfo, outInfo))
        return 1

    def _deform_mesh(self, mesh, inInfo, outInfo):
        """What is to be done for a mesh."""
        output = vtkDataSet.GetData(outInfo)
        arrays.check_lengths(mesh)
        if mesh.GetNumberOfPoints() == 0:
            output.ShallowCopy(mesh)
            return []
        deformation = self._requested_deformation(inInfo)
        self._check_reach(deformation, np.reshape(mesh.GetBounds(), (3, 2)).T)
        splits = self._splits if self._splits_cells else None
        return warping.Warp(self, deformation, mesh, output, splits).tasks()

    def _deform_image(self, image, inInfo, outInfo):
        """What is to be done for an image."""
        output = vtkImageData.GetData(outInfo)
        source = ImageGeometry.of_image(image)
        if source.is_empty:
            raise ValueError("`Input` is an empty image; it must have at least one point")
        deformation = self._requested_deformation(inInfo)
        whole_source = self._whole_input(source, inInfo[0].GetInformationObject(0))
        self._check_reach(deformation, whole_source.grid.corners())
        whole = self._output_geometry(whole_source, lambda: deformation)
        target = self._requested_part(whole, outInfo.GetInformationObject(0))
        target.apply_to(output)
        if target.is_empty:
            return []
        sampling = self._sampling(source.grid_within(whole_source), target.grid_within(whole))
        tasks = Resampling(self, deformation, image, output, sampling).tasks()
        return tasks + self._jacobian_tasks(deformation, output, sampling.target)

    def _sampling(self, source, target):
        """How images are sampled on the grid `source` for the points of another."""
        return Sampling(source, target, self._interpolation, self._background, self._void_values)

    def _whole_input(self, source, info):
        """All of the image of which the input is a part."""
        keys = vtkStreamingDemandDrivenPipeline
        whole = source.part(info.Get(keys.WHOLE_EXTENT()) or source.extent)
        if not whole.holds(source.extent):
            return source
        wanted = info.Get(keys.UPDATE_EXTENT())
        if wanted and whole.holds(wanted) and not source.holds(wanted):
            raise ValueError(
                "`Input` must be able to give any part of the image, "
                f"got the extent {source.extent} for {wanted}"
            )
        return whole

    def _output_geometry(self, source, make_deformation):
        """Where the whole output lies, for an input on `source`."""
        if self._output_grid == "input":
            return source
        if self._output_grid == "fitted":
            deformation = make_deformation()
            if self._fit is None or self._fit[:2] != (deformation, source):
                grid = deformation.fitted_grid(source.grid)
                self._fit = deformation, source, ImageGeometry.of_grid(grid)
            return self._fit[2]
        if self._output_grid == "given":
            direction = np.reshape(source.direction, (3, 3))
            try:
                grid = Grid(
                    self._output_dimensions, self._output_origin, self._output_spacing, direction
                )
            except (TypeError, ValueError) as error:
                raise ValueError(f"the given output grid is not one: {error}") from error
            return ImageGeometry.of_grid(grid)
        raise ValueError(
            f"`OutputGrid` must be one of input, fitted, given, got {shown(self._output_grid)}"
        )

    def _check(self, dataset):
        """Raise what is wrong with properties that the deformation has not."""
        for name, choices, choice in (
            ("interpolation", INTERPOLATIONS, self._interpolation),
            ("VoidValues", VOID_VALUES, self._void_values),
        ):
            if choice not in choices:
                raise ValueError(
                    f"`{name}` must be one of {', '.join(choices)}, got {shown(choice)}"
                )
        if self.is_among_blocks():  # another block may have the arrays
            return
        data = dataset.GetPointData(), dataset.GetCellData()
        for wanted, names in (
            ("LabelArrays", self._label_arrays),
            ("GradientVectorArrays", self._gradient_vector_arrays),
            ("PushForwardArrays", self._push_forward_arrays),
        ):
            for name in names:
                if not any(attributes.HasArray(name) for attributes in data):
                    there = [a.GetArrayName(i) for a in data for i in range(a.GetNumberOfArrays())]
                    raise ValueError(
                        f"`{wanted}` names `{name}`, which the input has not; it has "
                        f"{', '.join(f'`{each}`' for each in there) or 'no arrays'}"
                    )
