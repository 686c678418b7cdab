"""The map of a deformation in one region, as kernels evaluate it."""

from contextlib import ExitStack

import numpy as np

from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import FLOAT64, filled
from vtk_mls.engine.map.coarse_map import CoarseMap
from vtk_mls.engine.map.cut_tables import NO_CUTS, cut_tables
from vtk_mls.engine.map.handle_tables import map_tables
from vtk_mls.engine.map.nodes import OriginNodes

_STEP_FILES = "one_step.cl", "steps.cl"
_FLOAT_SHARE = 1 / 8  # of the tolerance, that errors of sums in float may have
# Structs of kernels that do not use them.
_NO_CUTS, _NO_NODES, _NO_CELLS = map(filled, ("cut_params_t", "nodes_t", "coarse_t"))
# Kernels that do not fit are built once for all kinds, alphas, shapes of handles and steps.
_WITHOUT_FIT = "coarse_", "nearest_sample", "node_cell"  # beginnings of names
_ANY_FIT = {"TWICE_ALPHA": 4, "FIT": "fit_rotation.cl", "SIMILARITY": 0, "FUNCTIONS": 0, "ORDER": 0}
_ANY_FIT |= {"REGIONS": 0, "REGION_FILE": "no_regions.cl", "STEPS": 0, "STEP_FILE": "one_step.cl"}
_ANY_FIT |= {"SEGMENTS": 0, "SEGMENT_FILE": "no_segments.cl"}


class RegionMap:
    """The map of a deformation in one region, as the kernels evaluate it.

    Its local frame is that of the `control_points` of the region.
    """

    def __init__(self, launcher, deformation, region):
        self.launcher, self.memory = launcher, launcher.memory
        self.deformation, self.region = deformation, region
        self.control_points = region.control_points
        # planes of "point_displacement": the void distance, too, if it needs more than G(v)
        self.displacements = 4 if deformation.void_needs_map else 3
        # by grid, None at points, and whether it is the second pass
        self._shared_arguments = {}
        searches = deformation.in_rest_frame and deformation.obstacles
        self._nodes = OriginNodes() if searches else None
        # Without searches a GPU evaluates the map at least as fast as it interpolates: an NVIDIA
        # H200, 64^3 to 256^3, 15 to 5,000 control points, 1 and 16 steps, takes 0.4 to 1 times.
        is_fast = launcher.device.kind == "gpu" and not deformation.obstacles
        has_nodes = deformation.map_tolerance > 0 and not is_fast
        self._coarse_map = CoarseMap() if has_nodes else None

    def launch_at(self, name, inputs, arguments=(), changed=(), outputs=()):
        """Launch a kernel at points of the local frame, the first of `inputs` (3, m) each.

        It takes the inputs, `arguments`, arrays that it changes, and arrays that it writes.
        """
        count = inputs[0].shape[1]
        if count == 0:
            return
        memory = self.memory
        with ExitStack() as stack:
            input_buffers = [stack.enter_context(memory.input_buffer(array)) for array in inputs]
            buffers = *map(memory.inout_buffer, changed), *map(memory.output_buffer, outputs)
            output_buffers = [stack.enter_context(buffer) for buffer in buffers]
            arguments = *input_buffers, *arguments, *output_buffers
            self.launch(name, (None, False), count, np.int64(count), *arguments)

    def at_points(self, name, planes, *points):
        """The output of a kernel at `points` (m, 3) each of the world: (planes, m) float32."""
        return self.at_local_points(name, planes, *map(self.local_points, points))

    def at_local_points(self, name, planes, *points):
        """The same at `points` (3, m) each of the local frame."""
        result = np.empty((planes, points[0].shape[1]), np.float32)
        self.launch_at(name, points, outputs=[result])
        return result

    def origins(self, points, starts=None):
        """G(v) of `points` (m, 3); void distances (m,), or None if G(v) suffices for them.

        Searches for the origins begin at `starts` (m, 3), if they are given.
        """
        control_points = self.control_points
        if starts is None or not self.deformation.obstacles:
            planes = self.at_points("point_displacement", self.displacements, points)
        else:
            planes = self.at_points("point_search", self.displacements, points, starts)
        displacement = control_points.mean_displacement + control_points.scale * planes[:3].T
        distance = None
        if self.displacements == 4:
            distance = control_points.scale * planes[3].astype(np.float64)
        return points + displacement, distance

    def jacobian(self, points, origins=None):
        """d(G - v)/dv at `points` (m, 3), of the material of `origins` if given: (9, m) float32."""
        if origins is None or not self.deformation.obstacles:
            return self.at_points("point_jacobian", 9, points)
        return self.at_points("origin_jacobian", 9, points, origins)

    def void_outputs(self, buffer):
        """Kernel arguments for void distances: a buffer or None, and the scale."""
        return [buffer, np.float32(self.control_points.scale)]

    def launch_on_grid(
        self, name, grid, part, *arguments, second_pass=False, coarsely=False, constants=()
    ):
        """Launch a kernel for the points `part` of a grid.

        The second pass computes the void points of other regions. Coarsely, displacements may be
        interpolated between nodes, within the deformation's `map_tolerance`.
        """
        # of several steps limits are not applied between nodes
        exactly = second_pass or (self.deformation.limits and self.deformation.steps_used > 1)
        if coarsely and not exactly and self._coarse_map and self._coarse_map.pays_off(self, grid):
            return self._coarse_map.launch(self, name, grid, part, *arguments, constants=constants)
        points = kernel_arguments.grid_points(grid, part, self.control_points)
        count = part.stop - part.start
        items = self.grid_items(grid, part)
        self.launch(
            *(name, (grid.whole, second_pass), count, points, *items, *arguments),
            constants=constants,
        )

    def launch_listed(self, name, grid, indices, *arguments, second_pass=False):
        """Launch a kernel for the points of a grid with ascending `indices` (m,) int64."""
        points = kernel_arguments.grid_points(grid, slice(0, len(indices)), self.control_points)
        span = slice(indices[0], indices[-1] + 1)
        with self.memory.input_buffer(indices) as listed:
            items = self.grid_items(grid, span, listed=listed)
            self.launch(
                *(name, (grid.whole, second_pass), len(indices), points, *items, *arguments),
                constants=(("POINTS", "LISTED"),),
            )

    def grid_items(self, grid, part, coarse=None, cells=None, listed=None):
        """Arguments of kernels over a grid: nodes of first guesses, listed cells, listed points."""
        nodes = self._nodes.around(self, grid, part) if self._nodes else [_NO_NODES, None]
        return [*nodes, _NO_CELLS if coarse is None else coarse, cells, listed]

    def local_points(self, points, offset=0):
        """`points` (m, 3) less `offset` in the local frame, (3, m) float32."""
        device = self.launcher.device
        center = self.control_points.center + offset
        if not device.has_float64:
            points, center = (points - center).astype(np.float32), np.zeros(3)
        local = np.empty((3, len(points)), np.float32)
        if len(points) == 0:
            return local
        float_type = np.float64 if device.has_float64 else np.float32
        frame = filled("local_frame_t", center=center, center_rest=center - np.float32(center))
        density = float_type(1 / self.control_points.scale)
        constants = ("LANES", device.lanes), ("VALUE", kernel_arguments.c_type(points))
        constants += FLOAT64 * device.has_float64
        memory, count, points = self.memory, len(points), np.ascontiguousarray(points)
        with memory.input_buffer(points) as x, memory.output_buffer(local) as out:
            arguments = np.int64(count), x, frame, density, out
            self.launcher.launch("local_points", constants, count, *arguments)
        return local

    def launch(self, name, grid_and_pass, count, *arguments, constants=(), spacing=None):
        """Launch a kernel of the map, for a whole grid or None and the first or second pass.

        `spacing` (3,) is that of the grid whose points are interpolated, by default of this one.
        """
        if grid_and_pass not in self._shared_arguments:
            self._shared_arguments[grid_and_pass] = self._map(*grid_and_pass)
        map_constants, shared = self._shared_arguments[grid_and_pass]
        whole, _ = grid_and_pass
        if spacing is None and whole is not None:
            spacing = whole.spacing
        if name.startswith(_WITHOUT_FIT):
            map_constants = {**_ANY_FIT, **dict(map_constants), **_ANY_FIT}.items()
        else:
            map_constants += self._digits(spacing)
        self.launcher.launch(name, (*map_constants, *constants), count, *shared, *arguments)

    def _digits(self, spacing):
        """The build constant with which kernels sum in double, if they must."""
        deformation, points = self.deformation, self.control_points
        max_error = 0.0
        if spacing is not None:
            tolerance = deformation.map_tolerance * min(spacing)
            max_error = _FLOAT_SHARE * tolerance / points.scale / deformation.steps_used
        needs_float64 = self.launcher.device.has_float64 and any(
            points.kind.needs_float64(deformation.alpha, step, max_error)
            for step in points.steps(deformation.steps_used)
        )
        return FLOAT64 if needs_float64 else ()

    def _map(self, grid, second_pass):
        """Build constants and shared kernel arguments of the map."""
        deformation, control_points = self.deformation, self.control_points
        alpha, device = deformation.alpha, self.launcher.device
        kind, steps = control_points.kind, control_points.steps(deformation.steps_used)
        handles = control_points.handles
        tables, starts = self._tables()
        params = filled(
            "map_params_t",
            count=handles.term_count,
            region_count=len(handles.regions),
            segment_count=len(handles.segments),
            limit_count=len(deformation.limits),
            step_count=len(steps),
            alpha=alpha,
            smoothing2=(deformation.smoothing / control_points.scale) ** 2,
            **starts,
            **kind.params(steps[0]),
        )
        alpha = alpha if kind.is_local else 2  # a spline has none
        constants = [
            ("TWICE_ALPHA", int(2 * alpha) if 2 * alpha in (1, 2, 3, 4, 6) else 0),
            ("FIT", kind.kernel),
            *_feature("REGION", "regions", handles.proxy_count),
            *_feature("SEGMENT", "segments", kind.segment_points * bool(len(handles.segments))),
            *_feature("LIMIT", "limits", bool(deformation.limits)),
            *(("STEPS", int(len(steps) > 1)), ("STEP_FILE", _STEP_FILES[len(steps) > 1])),
            ("LANES", device.lanes),
            *kind.constants().items(),
        ]
        of_cuts, cut_params, cut_table = NO_CUTS, _NO_CUTS, None
        if deformation.cuts:
            of_cuts, cut_params, table = cut_tables(deformation, self.region, grid, second_pass)
            cut_table = self.memory.constant(table)
        return (*constants, *of_cuts), [params, tables, cut_params, cut_table]

    def _tables(self):
        """A buffer of the `map_tables`, uploaded once, and where each begins."""
        uploaded = self.launcher.tables
        if self.control_points not in uploaded:
            table, starts = map_tables(self.deformation, self.control_points)
            uploaded[self.control_points] = self.memory.constant(table), starts
        return uploaded[self.control_points]


def _feature(name, file, value):
    """Build constants of a feature: its value or 0, and its file or that of its absence."""
    return (f"{name}S", int(value)), (f"{name}_FILE", f"{file}.cl" if value else f"no_{file}.cl")
