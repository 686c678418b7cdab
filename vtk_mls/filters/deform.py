"""Deform an image or a mesh."""

from contextlib import suppress
from functools import partial

import numpy as np
from vtkmodules.vtkCommonCore import vtkWeakReference
from vtkmodules.vtkCommonDataModel import (
    vtkDataObject,
    vtkDataObjectTypes,
    vtkDataSet,
    vtkImageData,
    vtkUniformGridAMR,
)
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline

from vtk_mls import Grid, Sampling
from vtk_mls.base.errors import InputError
from vtk_mls.base.sampling import AUTOMATIC
from vtk_mls.files.block_files import blocks
from vtk_mls.filters import (
    derived_arrays,
    initial_transforms,
    parallel,
    pipeline,
    property_tables,
    warping,
)
from vtk_mls.filters.algorithm import CachedValue, run_all
from vtk_mls.filters.deforming_filter import DeformingFilter, input_dataset
from vtk_mls.filters.image_resampling import (
    ImageOptions,
    Resampling,
    automatic_backgrounds,
    lattice_blocks,
)
from vtk_mls.filters.properties import with_properties
from vtk_mls.filters.reference_input import PORT, ReferenceInput
from vtk_mls.model.options import MAX_STEPS
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_SEAM = (
    "`Input` has images in several blocks that are not parts of one image, each of which is "
    "deformed by itself: what crosses a border between them is lost; make one image of them first "
    "(in ParaView by Resample To Image)"
)
_COARSE = (
    "{} of {} cells are inverted: their straight edges are too long for the deformation, and more "
    "steps do not help; refine the mesh, or lower `Blend` to the array that "
    "`GenerateLargestBlend` adds"
)
_FOLDED = (
    "{} of {} cells are inverted in 256 steps, the most: handles should not go through the same "
    "place at the same time; or lower `Blend` to the array that `GenerateLargestBlend` adds"
)


@with_properties(property_tables.DEFORM)
class MLSDeform(ReferenceInput, DeformingFilter):
    """Deforms an image or a mesh by control points.

    Input port 0 takes the dataset, port 1 (optional) control points, port 2 (optional, repeatable)
    cuts: see `DeformingFilter`. Port 5 (optional) takes an image as Reference: the output of an
    image has its grid. Composite data are deformed block by block. Images in blocks that lie on one
    lattice, have the same arrays and fill a box are sampled as one image, which needs the memory of
    the input once more. Material that crosses a border between other images is lost; a warning says
    so. AMR data are refused. Blocks without points, such as tables, are passed, and field data.
    `help` of a setter explains its property.

    Images are resampled with the backward map G (Eq. 2 of the paper): the value at v is the input's
    at G(v). Point and cell arrays keep their types, names and attributes; integers are rounded;
    strings, label arrays and `vtkGhostType` are taken from the nearest point. Where G is the
    identity, values are unchanged to the bit.

    Points of meshes are moved by the exact inverse of G, so that a mesh and an image deformed by
    the same control points stay registered. The output has the type of the input, except that a
    vtkRectilinearGrid becomes a vtkStructuredGrid; voxels become hexahedra, pixels quads, and
    points of integers float64. All arrays are kept, and "ForwardDisplacement"
    is the displacement of each point. Where G has no inverse (the map folds, what is there was
    pushed through a cut, or a coordinate is NaN) the point array "NoInverse" is 1, the point moves
    to the nearest position that the search found, and the field array "FailedInverses" counts.

    Directions are transformed with the map: gradients covariantly, by J_G^T (Eq. 29), namely the
    active normals, which keep length 1, and the GradientVectorArrays; the PushForwardArrays
    contravariantly, by J_G^-1. In images they are 0 in the void and outside of the input.

    With cuts, points of images have the arrays "Void" and "VoidDistance", cells "Void" (at their
    centers), and `vtkGhostType` hides the void: its points, and the cells that it fills or touches.
    VTK's surfaces, slices, thresholds and volume rendering leave these out (vtkContourFilter
    ignores ghosts of images). To clip or contour by VoidDistance, which gives a smooth face, turn
    HideVoid off, for cells on the face are needed then, and set VoidValues to "continued". Before
    VTK 9.3, whose vtkGeometryFilter crashes on hidden cells of images, only points are hidden; a
    threshold by Void leaves the void out there. Cells of meshes are split along cuts (see
    `splitting`); types that cannot hold the pieces become vtkUnstructuredGrid.

    A GPU keeps the arrays of images until they or the image are `Modified()`, or others need the
    memory. After writing into an array by numpy call that, or set `keeps_images` to False. Memory
    is that of input and output. Pieces of the output are computed independently, so that MPI
    processes share the work, and pieces of an image are, put together, the whole to the bit. Only
    the extent of the input image that a piece needs is requested; to know it, control points and
    cuts are updated in RequestUpdateExtent, and the map is evaluated once more.

    Attributes
    ----------
    keeps_images : bool
        Whether a GPU keeps the arrays of images for later updates.
    flags : set of str
        `__this__` of arrays of images that hold 0 and 1. They are sampled as labels are, with a
        background of 0 or 1.
    series_backgrounds : dict or None
        `backgrounds_of` the first image of a series whose images are set one after the other.
    corner_backgrounds : dict or None
        `automatic_backgrounds` of the first time, if the last update was of another or of a part.
    used_backgrounds : set of (name, number or tuple of numbers)
        Automatic backgrounds of the last update.
    """

    keeps_images = True
    flags = frozenset()
    series_backgrounds = None

    def __init__(self):
        # not vtkDataSet, which ParaView's GUI would try to make
        super().__init__(output_type="vtkDataObject", input_ports=PORT + 1)
        self._splits, self._between = warping.MeshCache(), warping.MeshCache()
        self._composite, self._lattice_blocks = vtkWeakReference(), None
        self._boxes = []  # of the blocks that are images, since VTK began with the blocks
        self._has_warned = False
        self._fitted, self._corners = CachedValue(), CachedValue()
        self.corner_backgrounds, self.used_backgrounds = None, set()

    def RequestDataObject(self, request, inInfo, outInfo):
        data = vtkDataObject.GetData(inInfo[0])
        if data is None:
            return 1
        if isinstance(data, (vtkImageData, vtkUniformGridAMR)):  # AMR data are an error later
            name = "vtkImageData"
        else:
            name = warping.output_type(data, self.GetSplitCells() and self._has_cuts())
        output = vtkDataObject.GetData(outInfo)
        if output is None or output.GetClassName() != name:
            is_same = data.GetClassName() == name
            output = data.NewInstance() if is_same else vtkDataObjectTypes.NewDataObject(name)
            output.Initialize()  # sets the extent of a vtkExplicitStructuredGrid
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
            geometry = self.output_geometry(geometry, lambda: self.updated_deformation(info))
        geometry.set_information(info)
        if self.GetOutputGrid() == "fitted" and not self.has_reference():
            pipeline.publish_changing_extent(info)
        return 1

    def RequestUpdateExtent(self, request, inInfo, outInfo):
        super().RequestUpdateExtent(request, inInfo, outInfo)
        self._request_reference()
        if not self.is_among_blocks():
            self._boxes, self._has_warned, self.used_backgrounds = [], False, set()
            self._composite.Set(vtkDataObject.GetData(inInfo[0]))
            self._end_blocks()
        if isinstance(vtkDataObject.GetData(inInfo[0]), vtkImageData):
            self._request_image(inInfo, outInfo)
        else:  # a mesh is deformed piece by piece, as it comes
            pipeline.reset_invalid_request(inInfo[0].GetInformationObject(0))
        return 1

    def _request_image(self, inInfo, outInfo):
        """Request the whole input image, or the extent that a part of the output needs."""
        info, out_info = inInfo[0].GetInformationObject(0), outInfo.GetInformationObject(0)
        pipeline.request_all(info)
        source, self.corner_backgrounds = ImageGeometry.of_information(info), None
        # RequestData meets the same errors and reports them
        with suppress(TypeError, ValueError, RuntimeError):
            whole = self.output_geometry(source, lambda: self.updated_deformation(out_info))
            target = self._requested_part(whole, out_info)
            is_whole = target == whole or source.is_empty or self._lacks_directions()
            if not is_whole or pipeline.first_time(info) is not None:
                self._find_corner_backgrounds(info, source)
            if is_whole:
                return
            pipeline.request_extent(info, pipeline.first_cell(source))
            if not target.is_empty:
                margin = pipeline.GRADIENT_REACH if self.GetGradientArray() else 0
                deformation = self.updated_deformation(out_info)
                sampling = self._sampling(source.grid, target.grid_within(whole))
                extent = pipeline.needed_extent(deformation, source, sampling, margin)
                pipeline.request_extent(info, extent)

    def _find_corner_backgrounds(self, info, source):
        """Find automatic backgrounds at the first time and at corners that are not requested."""
        if not self.GetAutomaticBackground() or self.is_among_blocks() or source.is_empty:
            return
        time, first = pipeline.requested_time(info), pipeline.first_time(info)

        def part_at(extent):
            request = partial(pipeline.request_extent, extent=extent)
            return self._update_input(0, time=time if first is None else first, request=request)

        try:
            state = self.GetInputExecutive(0, 0).GetPipelineMTime(), first, source.extent
            make = partial(automatic_backgrounds, source, part_at)
            self.corner_backgrounds = self._corners.of(state, make)
        finally:  # `info` is that of the producer
            pipeline.restore_time(info, time)
            pipeline.request_all(info)

    def RequestData(self, request, inInfo, outInfo):
        data = input_dataset(inInfo)
        self._check(data)
        deform = self._deform_image if isinstance(data, vtkImageData) else self._deform_mesh
        self._run(deform(data, inInfo, outInfo))
        return 1

    def _deform_mesh(self, mesh, inInfo, outInfo):
        """Functions of a Progress that deform a mesh."""
        self._refuse_reference_of(mesh)
        output = vtkDataSet.GetData(outInfo)
        arrays.check_lengths(mesh)
        if mesh.GetNumberOfPoints() == 0:
            output.ShallowCopy(mesh)
            return []
        deformations = self._requested_blends(inInfo)
        transform = self._with_initial(deformations.whole)
        self._check_reach(transform, np.reshape(mesh.GetBounds(), (3, 2)).T)
        splits = self._splits if self.GetSplitCells() else None
        initial, _ = initial_transforms.split_chain(transform)
        options = warping.MeshOptions(
            self._direction_arrays(),
            *self._jacobian_options(),
            self.GetGenerateCellQuality(),
            self.GetGenerateLargestBlend(),
        )
        arguments = options, deformations, mesh, output, splits
        make_warp = partial(warping.Warp, *arguments)
        if initial is not None:
            make_warp = partial(initial_transforms.WarpAfter, initial, self._between, *arguments)
        warp = make_warp()
        tasks = warp.tasks()
        if deformations.whole.steps == 0:
            tasks.append(partial(self._check_cells, warp, make_warp))
        return tasks + self._step_tasks(deformations.whole, output)

    def _check_cells(self, warp, make_warp, progress):
        """Mark cells that are inside out with an automatic number of steps, and warn of them.

        Where the map folds at their points, the steps are doubled first; but not for a part of a
        mesh, which must fit the others.
        """
        checking, again = progress.divided(1, 9)
        is_inverted, is_part = warp.inverted_cells(checking), self.is_among_blocks()
        while is_inverted.any() and not (is_part or parallel.is_parallel()):
            if not warp.deformation._add_steps(warp.points_of_inverted()):
                break
            warp = make_warp()
            run_all(warp.tasks(), again)
            is_inverted = warp.inverted_cells(again)
        arrays.add(warp.output.GetCellData(), "Folded", is_inverted)
        if is_inverted.any() and not self.GetGenerateLargestBlend():
            text = _COARSE if warp.deformation.steps_used < MAX_STEPS else _FOLDED
            self._warn(text.format(np.count_nonzero(is_inverted), len(is_inverted)))

    def _deform_image(self, image, inInfo, outInfo):
        """Functions of a Progress that deform an image."""
        output = vtkImageData.GetData(outInfo)
        output.GetPointData().Initialize()  # VTK leaves the scalars of the previous block
        source = ImageGeometry.of_image(image)
        if source.is_empty:
            raise ValueError("`Input` is an empty image; it must have at least one point")
        deformation = self._requested_deformation(inInfo)
        block = self._lattice_block(image) if self.is_among_blocks() else None
        if block is None:
            whole_source = self._whole_input(source, inInfo[0].GetInformationObject(0))
        else:
            whole_source = ImageGeometry.of_image(block.image)
        self._check_reach(deformation, whole_source.grid.corners())
        if self.is_among_blocks():
            self._check_border(deformation, whole_source.grid, block)
        whole = self.output_geometry(source if block else whole_source, lambda: deformation)
        self._check_arrival(deformation, whole_source, whole)
        target = self._requested_part(whole, outInfo.GetInformationObject(0))
        target.apply_to(output)
        if target.is_empty:
            return []
        if block is None:
            grids = source.grid_within(whole_source), target.grid_within(whole)
        else:
            part = whole_source.part(block.extent).grid_within(whole_source)
            grids = whole_source.grid, part if target == source else target.grid_within(whole)
            image = block.image
        sampling = self._sampling(*grids)
        options = self._image_options(image, block)
        backgrounds = self.series_backgrounds or self.corner_backgrounds
        resampling = Resampling(options, deformation, image, output, sampling, backgrounds)
        resampling.used_backgrounds = self.used_backgrounds
        return resampling.tasks() + self._grid_tasks(deformation, output, sampling.target)

    def _lattice_block(self, image):
        """The `LatticeBlock` of an image among blocks, or None; all blocks are up to date now."""
        if self._lattice_blocks is None:
            composite = self._composite.Get()
            self._lattice_blocks = lattice_blocks(blocks(composite) if composite else [])
        return self._lattice_blocks.get(image.__this__)

    def _end_blocks(self):
        self._lattice_blocks = None  # they need as much memory as the blocks

    def _direction_arrays(self):
        names = self.GetGradientVectorArrays(), self.GetPushForwardArrays()
        return derived_arrays.DirectionArrays(*names, self.GetNormalizeGradient())

    def _image_options(self, image, block=None):
        gradient_array = self.GetGradientArray()
        if self.is_among_blocks() and not image.GetPointData().HasArray(gradient_array):
            gradient_array = ""  # another block may have it
        flags = self.flags
        if block is not None:
            flags |= {joined for joined, own in block.same_arrays.items() if own in flags}
        return ImageOptions(
            directions=self._direction_arrays(),
            gradient_array=gradient_array,
            label_arrays=self.GetLabelArrays(),
            flags=flags,
            hides_void=self.GetHideVoid(),
            is_cached=self.keeps_images,
        )

    def _check_border(self, deformation, grid, block):
        """Warn once if the block may need material of another one that is not joined to it.

        Blocks at the same position are several images of the same material, no neighbors.
        """
        joined = block and block.image.__this__
        corners, moved = grid.corners(), np.subtract(*deformation._material_samples(grid))
        reach = np.linalg.norm(moved, axis=1).max(initial=0)
        low, high = corners.min(axis=0), corners.max(axis=0)
        others = [box for box, image in self._boxes if image is None or image != joined]
        if others and reach > 0 and not self._has_warned:
            lows, highs = np.swapaxes(others, 0, 1)
            margin = reach + grid.spacing.max()
            is_near = ((lows <= high + margin) & (low - margin <= highs)).all(axis=1)
            is_same = ((lows == low) & (highs == high)).all(axis=1)
            if (is_near & ~is_same).any():
                self._has_warned = True
                self._warn(_SEAM)
        self._boxes.append(((low, high), joined))

    def _sampling(self, source, target):
        background = AUTOMATIC if self.GetAutomaticBackground() else self.GetBackground()
        return Sampling(source, target, self.GetInterpolation(), background, self.GetVoidValues())

    def _whole_input(self, source, info):
        """ImageGeometry of the whole image that the input is a part of."""
        keys = vtkStreamingDemandDrivenPipeline
        whole = source.part(info.Get(keys.WHOLE_EXTENT()) or source.extent)
        if not whole.holds(source.extent):
            return source
        requested = info.Get(keys.UPDATE_EXTENT())
        if requested and whole.holds(requested) and not source.holds(requested):
            raise ValueError(
                "`Input` must be able to give any part of the image, "
                f"got the extent {source.extent} for {requested}"
            )
        return whole

    def output_geometry(self, source, make_deformation):
        """ImageGeometry of the whole output, for an input on the ImageGeometry `source`.

        `make_deformation()` is called where the output grid depends on the deformation.
        """
        reference = self._reference_geometry()
        if reference is not None:
            return reference
        choice = property_tables.OUTPUT_GRID.checked(self)
        if choice == "input":
            return source
        if choice == "fitted":
            deformation = make_deformation()
            make = partial(deformation.fitted_grid, source.grid)
            return ImageGeometry.of_grid(self._fitted.of((deformation, source), make))
        axes = self.GetOutputDimensions(), self.GetOutputOrigin(), self.GetOutputSpacing()
        try:
            grid = Grid(*axes, np.reshape(source.direction, (3, 3)))
        except InputError as error:
            name = f"Output{error.argument.capitalize()}"
            raise InputError(error.predicate, argument=name) from error
        return ImageGeometry.of_grid(grid)

    def _check(self, dataset):
        """Raise errors of the properties that are no options of the deformation."""
        for choice in (property_tables.INTERPOLATION, property_tables.VOID_VALUES_CHOICE):
            choice.checked(self)
        if self.is_among_blocks():  # another block may have the arrays
            return
        data = dataset.GetPointData(), dataset.GetCellData()
        for argument in ("LabelArrays", "GradientVectorArrays", "PushForwardArrays"):
            for name in getattr(self, f"Get{argument}")():
                if not any(attributes.HasArray(name) for attributes in data):
                    available = [a.GetName() for d in data for a in arrays.all_arrays(d)]
                    raise ValueError(
                        f"`{argument}` names `{name}`, which the input has not; it has "
                        f"{', '.join(f'`{array}`' for array in available) or 'no arrays'}"
                    )
