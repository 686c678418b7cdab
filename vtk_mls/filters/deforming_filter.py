"""Base of the filters that evaluate a deformation."""

from functools import partial

import numpy as np
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataObject,
    vtkDataSet,
    vtkImageData,
    vtkUniformGridAMR,
)
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm

from vtk_mls import Chain, Deformation, RegionHandle
from vtk_mls.base.errors import InputError
from vtk_mls.filters import (
    derived_arrays,
    initial_transforms,
    map_inputs,
    parallel,
    pipeline,
    property_tables,
)
from vtk_mls.filters.algorithm import Algorithm, CachedValue, inputs
from vtk_mls.filters.properties import with_properties
from vtk_mls.filters.warping import Blends
from vtk_mls.model import options
from vtk_mls.model.handles.handle_cells import handles_of_cells
from vtk_mls.model.handles.handle_paths import blended_path
from vtk_mls.queries.handle_warnings import handle_warnings
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import PATH, as_polydata, cells_of, path_of
from vtk_mls.vtk.objects import shallow_copy

# Ports: control points, cuts, mask, deformed control points. Processes share all but masks.
_PORTS, _POINT_SETS, _SHARED = (1, 2, 3, 4), (1, 4), (1, 2, 4)
_ANCHOR = np.zeros((1, 3))
_AT_REST = (
    "`Input` has a {} in a block, which is passed and stays at rest; make a mesh of it first if it "
    "is to move, too"
)


@with_properties(property_tables.DEFORMING)
class DeformingFilter(Algorithm):
    """Base of the filters that have control points and cuts.

    Control points are a vtkPointSet (polydata, an unstructured grid, ...) on input port 1, if
    something is connected there: its points, in cells or not, are p, in the undeformed space, and a
    point vector array holds the displacement q - p. That is the array "Displacement", unless
    `SetInputArrayToProcess(0, 1, 0, POINTS, name)` names another;
    `SetInputArrayToProcess(1, 1, 0, POINTS, name)` names an array with a positive factor for each,
    "Weight" by default, which may be absent. The array "Path" of 3 k components, if it is there,
    holds the displacements from p to k intermediate places, at equal times between p and q: points
    can turn by more than 180 degrees. Otherwise control points are those of the properties
    RestPoints, DeformedPoints and Weights; without any, nothing moves. With HandleShapes "cells"
    the cells of port 1 are handles, and the points of these count only there: curves and regions
    have no path.

    A vtkPointSet on input port 4 is that of port 1, moved: its points, by index, are q then, and
    there is no displacement array. So a surface and the output of its vtkTransformFilter are a
    rigid region.

    Cuts are those of the properties CutType and Cuts, and the surfaces of any number of polydata on
    input port 2 (see `map_inputs.surfaces`): polygons and triangle strips, each connected surface a
    cut; lines and vertices are ignored. They are in the undeformed volume and go with the material,
    or stay in the deformed space, as CutFrame says. Material on one side of a cut follows the
    control points of that side, and where the cut opens there is nothing: the output's point array
    "Void" is 1 there, and "VoidDistance" is below 0 and continuous, so that its zero level is the
    smooth face of the void (contour or clip by it; an isosurface of "Void" has steps).

    InitialTransform moves the material first: control points at rest and cuts in the rest frame are
    in the space that it leads to, and all else is that of both.

    The deformation acts where a mask lets it, MaskBall, Mask or an image on input port 3, and holds
    FixedPlanes, SlidingPlanes and Constraints.

    All inputs may change in time, each at steps of its own. The output has the steps of all; each
    input is asked for the requested time, and says itself which of its steps that is.

    On several processes, control points and cuts count wherever they are: all that the processes
    have, in the order of ranks; or once, if those that have some have exactly the same. Each
    process requests the whole of a mask.

    Attributes
    ----------
    warns_of_overlap : bool
        Whether there is a warning about rigid regions that overlap.
    """

    warns_of_overlap = True
    _collected = None  # state of the shared ports when processes shared them, and the data

    def __init__(self, output_type="vtkImageData", input_ports=5):
        super().__init__(
            nInputPorts=input_ports, inputType="vtkDataSet", nOutputPorts=1, outputType=output_type
        )
        self._solids = []  # of the last regions
        self._cuts_cache, self._limits_cache = CachedValue(), CachedValue()
        self._deformation_cache, self._chain_cache = CachedValue(), CachedValue()
        self._initial_cache = CachedValue()
        self._warned = CachedValue()

    def FillInputPortInformation(self, port, info):
        required = vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE()
        # The second types are refused by RequestData: by itself VTK would take them apart.
        types = (
            (self.InputType, "vtkUniformGridAMR"),
            ("vtkPointSet", "vtkCompositeDataSet"),
            ("vtkPolyData",),
            ("vtkImageData",),
            ("vtkPointSet", "vtkCompositeDataSet"),
            ("vtkImageData",),  # of `ReferenceInput`
        )
        for name in types[port]:
            info.Append(required, name)
        if port > 0:
            info.Set(vtkAlgorithm.INPUT_IS_OPTIONAL(), 1)
        if port == 2:
            info.Set(vtkAlgorithm.INPUT_IS_REPEATABLE(), 1)
        return 1

    def _answer(self, name, request, inInfo, outInfo):
        data = vtkDataObject.GetData(inInfo[0])
        if data is None or isinstance(data, (vtkDataSet, vtkCompositeDataSet)):
            return super()._answer(name, request, inInfo, outInfo)
        if name in ("RequestDataObject", "RequestData"):  # a block that is no dataset
            outInfo.GetInformationObject(0).Set(vtkDataObject.DATA_OBJECT(), shallow_copy(data))
        if name == "RequestData" and hasattr(data, "GetBounds"):
            self._warn(_AT_REST.format(data.GetClassName()))
        return 1

    def SetInputData(self, *port_and_data):
        """`(data)` for port 0 or `(port, data)`: input that no algorithm makes."""
        self.SetInputDataObject(*port_and_data)

    def DisconnectControlPoints(self):
        """Remove the input from port 1: those of the properties count again."""
        self.RemoveAllInputConnections(1)

    def DisconnectCuts(self):
        """Remove all inputs from port 2."""
        self.RemoveAllInputConnections(2)

    def DisconnectMask(self):
        """Remove the input from port 3."""
        self.RemoveAllInputConnections(3)

    def DisconnectDeformedControlPoints(self):
        """Remove the input from port 4: positions q are those of displacements again."""
        self.RemoveAllInputConnections(4)

    def _has_cuts(self):
        has_own = self.GetCutType() != "none" or self.GetCuts()
        return has_own or self.GetNumberOfInputConnections(2) > 0

    def RequestUpdateExtent(self, request, inInfo, outInfo):
        if parallel.is_parallel():
            self._collect(outInfo.GetInformationObject(0))
        for information in inInfo[1:]:
            for index in range(information.GetNumberOfInformationObjects()):
                pipeline.request_all(information.GetInformationObject(index))
        return 1

    def _collect(self, info=None):
        """Data on the shared ports, from all processes.

        All processes must call this at the same times, in RequestInformation and in
        RequestUpdateExtent. They communicate only after a change upstream, which all see.
        """
        counts = {port: self.GetNumberOfInputConnections(port) for port in _SHARED}
        connections = [(port, index) for port in counts for index in range(counts[port])]
        state = self._upstream(connections, info)
        if self._collected is not None and self._collected[0] == state:
            return

        def update():
            return [
                as_polydata(data) if port in _POINT_SETS else data
                for port, index in connections
                for data in [self._update_input(port, index, state[-1])]
            ]

        try:
            data = dict(zip(connections, parallel.gather_polydata(update))) if connections else {}
        except ValueError as error:
            data = error
        self._collected = state, data

    def _upstream(self, connections, info):
        """Connections, the pipeline's modification time of each, and the requested time."""
        changes = [self.GetInputExecutive(*pair).GetPipelineMTime() for pair in connections]
        return connections, changes, pipeline.requested_time(info)

    def _control_data(self, make_inputs):
        """Lists of the data on ports 1 to 4; `make_inputs(port)` gives those of this process."""
        if not parallel.is_parallel() or self._collected is None:
            return [make_inputs(port) for port in _PORTS]
        data = self._collected[1]
        if isinstance(data, ValueError):
            raise data
        return [
            [item for (shared_port, _), item in data.items() if shared_port == port]
            if port in _SHARED
            else make_inputs(port)
            for port in _PORTS
        ]

    def _requested_part(self, target, info):
        """The part of the output requested by downstream, if it has the geometry of the output."""
        if arrays.ImageGeometry.of_information(info).part(()) == target.part(()):
            extent = pipeline.requested_extent(info)
            part = target.part(extent)
            if part.is_empty or target.holds(extent):
                return part
        return target

    def updated_deformation(self, info=None):
        """The Deformation of the properties, and of control points and cuts, which are updated.

        With an InitialTransform it is the last of two in a Chain. The filter itself does not run.
        `info` of an output gives the time.
        """
        if parallel.is_parallel():
            self._collect(info)

        def updated(port):
            count = self.GetNumberOfInputConnections(port)
            time = pipeline.requested_time(info)
            return [self._update_input(port, index, time) for index in range(count)]

        return self._with_initial(self._blends(*self._control_data(updated)).whole)

    def _requested_deformation(self, in_info):
        """The deformation by the inputs of RequestData."""
        return self._with_initial(self._requested_blends(in_info).whole)

    def _with_initial(self, deformation):
        """The deformation, or a chain of the InitialTransform and the deformation."""
        initial = initial_transforms.read_initial(self.GetInitialTransform(), self._initial_cache)
        if initial is None:
            return deformation
        return self._chain_cache.of((initial, deformation), partial(Chain, [initial, deformation]))

    def _requested_blends(self, in_info):
        """`Blends` of the deformation by the inputs of RequestData."""
        blends = self._blends(*self._control_data(lambda port: inputs(in_info, port)))

        def warn():
            for sentence in handle_warnings(blends.whole, self.warns_of_overlap):
                self._warn(sentence)

        self._warned.of(blends.whole, warn)  # once
        return blends

    def _blends(self, *data):
        """`Blends` of the deformation by data of ports 1 to 4; cached until something changes."""
        state, make = self._recipe(*data)
        whole = self._deformation_cache.of(state, lambda: make(self.GetBlend()))
        return Blends(self.GetBlend(), whole, make)

    def _recipe(self, control_points, surfaces, masks, moved):
        """What the deformation by data of ports 1 to 4 depends on, and a function of the blend."""
        if moved and not control_points:
            raise ValueError(
                "`DeformedControlPoints` is what `ControlPoints` is, moved: connect that, too"
            )
        names = map_inputs.control_point_arrays(self, *control_points) if control_points else ()
        shapes = property_tables.HANDLE_SHAPES_CHOICE.checked(self)
        cuts, limits = self._all_cuts(surfaces), self._all_limits(masks)
        cut_frame = options.CUT_FRAME.checked(self.GetCutFrame(), "CutFrame")
        data = _stamps([*control_points, *moved])
        lists = self.GetRestPoints(), self.GetDeformedPoints(), self.GetWeights()
        state = (data, names or lists, self.GetBlend(), cuts, cut_frame)
        settings = {
            option.name: getattr(self, f"Get{option.property_name}")()
            for option in options.DEFORMATION_OPTIONS
        }
        settings |= {"cut_frame": cut_frame, "device": self.GetDevice() or None}
        state += (shapes, self.GetHandles(), limits, *settings.values())

        def make(blend):
            rest, deformed, weights, path, handles = self._all_handles(
                control_points, moved, names, shapes
            )
            blend, (mask, faces) = options.BLEND.checked(blend, "Blend"), limits
            if blend != 1:
                deformed, path = blended_path(rest, deformed, path, blend)
                handles = [handle.blended(blend) for handle in handles]
            return Deformation(
                rest,
                deformed,
                weights=weights,
                path=path,
                handles=handles,
                cuts=cuts,
                mask=mask,
                constraints=faces,
                **settings,
            )

        return state, make

    def _all_handles(self, control_points, moved, names, shapes):
        """p, q, weights and path of points, and the other handles."""
        handles = list(self.GetHandles())
        if not control_points:
            return *self._own_control_points(), (), handles
        points = arrays.control_points(*control_points, *names, *moved)
        path = path_of(*control_points)
        if shapes == "cells":
            cells = cells_of(*control_points)
            path = path[:, cells.point_rows]
            *points, shaped = handles_of_cells(*points, cells, self._solids)
            self._solids = [item.shape for item in shaped if isinstance(item, RegionHandle)]
            handles += shaped
        return *points, path, handles

    def _all_limits(self, images):
        """Mask and faces; the same objects until one of them changes."""
        ball, mask, faces = self.GetMaskBall(), self.GetMask(), self.GetConstraints()
        planes = self.GetFixedPlanes(), self.GetSlidingPlanes()
        own = [mask] if isinstance(mask, vtkImageData) else []

        def make():
            return map_inputs.one_mask(ball, mask, images), (*map_inputs.faces(*planes), *faces)

        return self._limits_cache.of((ball, mask, faces, planes, _stamps([*images, *own])), make)

    def _all_cuts(self, surfaces):
        """The cuts of properties and port 2; the same objects until one of them changes."""
        own = map_inputs.own_values(self)

        def make():
            cuts = [cut for polydata in surfaces for cut in map_inputs.surfaces(polydata)]
            return *map_inputs.own_cuts(*own), *self.GetCuts(), *cuts

        return self._cuts_cache.of((own, self.GetCuts(), _stamps(surfaces)), make)

    def _own_control_points(self):
        """p, q and weights by properties; without any, one control point at rest."""
        rest, deformed, weights = map_inputs.listed_control_points(self)
        if np.abs(rest).max(initial=0) > np.finfo(np.float32).max:
            raise ValueError(
                f"`RestPoints` must be places, got {rest[0].tolist()}: the input had no bounds yet "
                "when they were laid over it; update the input, then lay or set them anew"
            )
        cuts = map_inputs.own_cuts(*map_inputs.own_values(self))
        rest, is_ignored = map_inputs.off_cuts(cuts, rest, deformed, self.GetCutFrame())
        if is_ignored.all() and not self.GetHandles():
            return _ANCHOR, _ANCHOR, None
        mask = ~is_ignored
        return rest[mask], deformed[mask], None if weights is None else weights[mask]

    def _check_reach(self, deformation, corners):
        """Raise if float32, in the control points' frame, cannot tell the data's points apart.

        The data are in the box round `corners` (n, 3).
        """
        initial, deformation = initial_transforms.split_chain(deformation)
        if initial is not None:
            corners = initial.forward(corners)
            corners = corners[np.isfinite(corners).all(axis=1)]
            if len(corners) == 0:
                return
        low, high = np.min(corners, axis=0), np.max(corners, axis=0)
        size = (high - low).max()
        distance = np.abs(np.concatenate(deformation.handle_set.positions) - (low + high) / 2).max()
        if 0 < size < distance * np.finfo(np.float32).eps:
            raise InputError(
                f"must be where the data are: one is {distance:g} away from their middle, and they "
                f"are {size:g} large, which float32 cannot tell from a point then",
                argument="ControlPoints" if self.GetNumberOfInputConnections(1) else "RestPoints",
            )

    def _grid_tasks(self, transform, output, grid, is_field=False):
        """Functions of a Progress that add arrays to an image on a grid; they read "Void"."""
        tasks, options = [], self._jacobian_options()
        if transform.cuts and self.GetGenerateOverlap():
            tasks.append(partial(derived_arrays.add_overlap, output, transform, grid))
        if step_tasks := self._step_tasks(transform, output):
            tasks += [partial(_add_folds, output, transform, grid, is_field), *step_tasks]
        if any(options):
            tasks.append(partial(_add_jacobian, output, transform, grid, options))
        return tasks

    def _step_tasks(self, transform, output):
        """Functions of a Progress that add the number of automatic steps."""
        _, deformation = initial_transforms.split_chain(transform)
        return [partial(_add_steps, output, deformation)] if deformation.steps == 0 else []

    def _jacobian_options(self):
        """Whether the Jacobian and its determinant are generated."""
        return self.GetGenerateJacobian(), self.GetGenerateJacobianDeterminant()


def _add_steps(output, deformation, progress):
    arrays.add(output.GetFieldData(), "StepsUsed", deformation.steps_used)
    arrays.add(output.GetFieldData(), "SmallestDeterminant", deformation.smallest_determinant)
    if len(deformation.path_used) > len(deformation.path):
        moves = [places - deformation.rest for places in deformation.path_used]
        arrays.add(output.GetFieldData(), PATH, np.hstack(moves))


def _add_folds(output, transform, grid, is_field, progress):
    folded = transform._folded_points(grid, progress, is_field)
    arrays.add(output.GetPointData(), "Folded", folded.ravel())


def _add_jacobian(output, deformation, grid, options, progress):
    void = False
    if deformation.cuts:
        void = arrays.to_numpy(output.GetPointData().GetArray("Void")).reshape(grid.shape) > 0
    mapping, adding = progress.divided(3, 1)
    jacobian = deformation.jacobian_field(grid, mapping)
    adding.report(0)
    derived_arrays.add_jacobian(output, jacobian, void, *options)


def input_dataset(in_info):
    """The vtkDataSet on port 0 in RequestData; raises if a port has data in parts."""
    data = vtkDataObject.GetData(in_info[0])
    if isinstance(data, vtkUniformGridAMR):
        raise ValueError(
            f"`Input` must be an image or a mesh, got AMR data ({data.GetClassName()}), whose "
            "levels would not fit each other any more; resample it to one image first "
            "(vtkResampleToImage, in ParaView Resample To Image)"
        )
    for port, name in ((1, "ControlPoints"), (4, "DeformedControlPoints")):
        for handles in inputs(in_info, port):
            if isinstance(handles, vtkCompositeDataSet):
                raise ValueError(
                    f"`{name}` must be one point set, got a {handles.GetClassName()}; merge its "
                    "blocks first (in ParaView Merge Blocks, in PyVista `combine()`)"
                )
    return data


def _stamps(data):
    """Keys of data objects, without references to them.

    In VTK 9.6 the attributes of a filter held by ParaView outlive it, and VTK crashes if data
    objects end with them.
    """
    return [(item.__this__, item.GetMTime()) for item in data]
