"""The displacement map of a deformation as an image."""

from functools import partial

import numpy as np
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkDataSet, vtkImageData
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline

from vtk_mls import Grid
from vtk_mls.files import metadata, nifti
from vtk_mls.filters import derived_arrays, parallel, pipeline, property_tables
from vtk_mls.filters.deforming_filter import DeformingFilter, input_dataset
from vtk_mls.filters.properties import with_properties
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

# Number of points whose forward images are searched at once.
_CHUNK = 1 << 20


@with_properties(property_tables.DISPLACEMENT_FIELD)
class MLSDisplacementField(DeformingFilter):
    """Makes an image with the displacement G(v) - v of each of its points v.

    Input port 0 takes any dataset: an image gives its grid, everything else its bounds, which are
    filled with SampleDimensions points (one across a direction in which they are flat). Port 1
    (optional) takes control points, port 2 (optional, repeatable) cuts: see `DeformingFilter`.
    docs/properties.md lists the properties; `help` of a setter says what each is.

    The point array "BackwardDisplacement", three floats, is the output's active scalars and
    vectors, as `vtkGridTransform` wants it; with that transform `vtkImageReslice` deforms as
    `MLSDeform` does (`vtkGridTransform` ignores direction matrices). With cuts there are "Void" and
    "VoidDistance".

    With Inverse the map is F, the true inverse of G, which says where the material at x goes: the
    active array is "ForwardDisplacement", F(x) - x. Where F has no value (the map folds, or a cut
    has been pushed over x) it is the displacement to the nearest position that the search found,
    the point array "NoInverse" is 1, and the field array "FailedInverses" counts. The Jacobian is
    that of F, and 0 there; there is no void. Pieces are the whole to the tolerance of
    `Deformation.forward` then.

    No data of an input image is used, and only one cell of it is requested. Pieces of the output
    are computed independently and are, put together, the whole to the bit. Another input is updated
    in RequestInformation, for its bounds. On several processes each takes its piece of it, and the
    bounds are those of all pieces. (A block of composite data has the bounds that it has on the
    process.)
    """

    def __init__(self):
        super().__init__()
        self._shared_boxes = None  # state of port 0 when processes shared their boxes, and these

    def RequestInformation(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        info.Set(vtkAlgorithm.CAN_PRODUCE_SUB_EXTENT(), 1)
        vtkDataObject.SetPointDataActiveScalarInfo(info, VTK_FLOAT, 3)
        if isinstance(vtkDataSet.GetData(inInfo[0]), vtkImageData):
            ImageGeometry.of_information(inInfo[0].GetInformationObject(0)).set_information(info)
            return 1
        try:
            if self._is_shared():
                self._share_boxes(info)
            boxes = self._boxes(lambda: self._update_input(0, time=pipeline.requested_time(info)))
            self._sampled_lattice(boxes).set_information(info)
        except (TypeError, ValueError):
            ImageGeometry((0, -1, 0, -1, 0, -1)).set_information(info)  # RequestData reports why
        pipeline.publish_changing_extent(info)
        return 1

    def RequestUpdateExtent(self, request, inInfo, outInfo):
        info, dataset = inInfo[0].GetInformationObject(0), vtkDataSet.GetData(inInfo[0])
        if isinstance(dataset, vtkImageData):
            pipeline.request_extent(info, pipeline.first_cell(ImageGeometry.of_information(info)))
        elif dataset is not None and self._is_shared():
            self._share_boxes(outInfo.GetInformationObject(0))
            parallel.request_share(info)
        else:
            pipeline.request_all(info)
        return super().RequestUpdateExtent(request, inInfo, outInfo)

    def RequestData(self, request, inInfo, outInfo):
        dataset = input_dataset(inInfo)
        output = vtkImageData.GetData(outInfo)
        deformation = self._requested_deformation(inInfo)
        if isinstance(dataset, vtkImageData):
            info = inInfo[0].GetInformationObject(0)
            extent = info.Get(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT())
            whole = ImageGeometry.of_image(dataset)
            whole = whole.part(extent or whole.extent)
            lines = nifti.geometry_lines(metadata.load(dataset, metadata.NIFTI_HEADER))
            metadata.store(output, metadata.NIFTI_HEADER, lines)
            if whole.is_empty:
                raise ValueError("`Input` is an empty image; it must have at least one point")
        else:
            whole = self._sampled_lattice(self._boxes(lambda: dataset))
        self._check_reach(deformation, whole.grid.corners())
        target = self._requested_part(whole, outInfo.GetInformationObject(0))
        target.apply_to(output)
        if target.is_empty:
            return 1
        grid = target.grid_within(whole)
        if self.GetInverse():
            tasks = [partial(self._fill_forward, output, deformation, grid)]
            tasks += self._step_tasks(deformation, output)
        else:
            tasks = [partial(self._fill_backward, output, deformation, grid)]
            tasks += self._grid_tasks(deformation, output, grid, is_field=True)
        self._run(tasks)
        return 1

    def _fill_backward(self, output, deformation, grid, progress):
        field = deformation.displacement_field(grid, progress=progress)
        _add_field(output, "BackwardDisplacement", field.displacement.reshape(-1, 3))
        if deformation.cuts:
            derived_arrays.add_void(output.GetPointData(), field.void_distance)

    def _fill_forward(self, output, deformation, grid, progress):
        options = self._jacobian_options()
        with_jacobian = any(options)
        displacement, found = np.empty((grid.size, 3), np.float32), np.empty(grid.size, bool)
        jacobian = np.zeros((grid.size if with_jacobian else 0, 3, 3), np.float32)
        for part, chunk in progress.chunks(grid.size, _CHUNK):
            x = grid.points(part.start, part.stop)
            searching, mapping = chunk.divided(2, 1)
            field = deformation.forward_field(x, searching)
            displacement[part], found[part] = field.displacement, field.found
            if with_jacobian:
                jacobian[part] = _inverse_jacobian(deformation, x, field, mapping)
        _add_field(output, metadata.FORWARD_DISPLACEMENT, displacement)
        arrays.add(output.GetPointData(), "NoInverse", ~found)
        arrays.add(output.GetFieldData(), "FailedInverses", np.count_nonzero(~found))
        if with_jacobian:
            derived_arrays.add_jacobian(
                output, jacobian.reshape(*grid.shape, 3, 3), False, *options
            )

    def _share_boxes(self, info=None):
        """Tell all processes the bounds of the input's pieces; to be called like `_collect`."""
        state = self._upstream([(0, 0)], info)
        if self._shared_boxes is not None and self._shared_boxes[0] == state:
            return

        def box():
            return _box(self._update_input(0, time=state[-1], request=parallel.request_share))

        try:
            boxes = parallel.gather_results(box)
        except ValueError as error:
            boxes = error
        self._shared_boxes = state, boxes

    def _boxes(self, make_dataset):
        """Bounds of the input, or of its pieces on all processes; None where there is no point."""
        if not self._is_shared():
            return [_box(make_dataset())]
        boxes = self._shared_boxes[1]
        if isinstance(boxes, ValueError):
            raise boxes
        return boxes

    def _is_shared(self):
        """Whether the input is in pieces on processes: not a block, whose number can differ."""
        return parallel.is_parallel() and not self.is_among_blocks()

    def _sampled_lattice(self, boxes):
        """SampleDimensions points over all boxes."""
        boxes = [box for box in boxes if box is not None]
        if not boxes:
            raise ValueError("`Input` is empty; its bounds are needed for the displacement field")
        low, high = np.min(boxes, axis=0)[::2], np.max(boxes, axis=0)[1::2]
        size = high - low
        dimensions = np.where(size > 0, property_tables.SAMPLE_DIMENSIONS.checked(self), 1)
        spacing = np.where(size > 0, size / np.maximum(dimensions - 1, 1), 1.0)
        origin = np.where(dimensions > 1, low, low + size / 2)
        return ImageGeometry.of_grid(Grid(dimensions, origin, spacing))


def _box(dataset):
    """Bounds of a dataset, None without points that are finite."""
    bounds = dataset.GetBounds()
    return bounds if dataset.GetNumberOfPoints() > 0 and bounds[0] <= bounds[1] else None


def _add_field(output, name, displacement):
    """Make displacements (n, 3) float32 an image's active scalars and vectors."""
    array = configured(arrays.from_numpy(displacement, VTK_FLOAT), Name=name)
    output.GetPointData().SetScalars(array)
    output.GetPointData().SetActiveVectors(name)


def _inverse_jacobian(deformation, x, field, progress):
    """dF_i/dx_j (n, 3, 3) at the points x (n, 3), 0 where F has no value or no derivative."""
    jacobian = deformation.jacobian(x + field.displacement, progress, x)
    usable = field.found & (np.linalg.det(jacobian) != 0)
    inverse = np.zeros_like(jacobian)
    inverse[usable] = np.linalg.inv(jacobian[usable])
    return inverse
