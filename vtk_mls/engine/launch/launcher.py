"""Kernels of an OpenCL device: built at their first use, launched in slabs."""

from __future__ import annotations

import weakref
from contextlib import ExitStack

import numpy as np

from vtk_mls.engine.device import devices
from vtk_mls.engine.launch import array_types, kernel_arguments
from vtk_mls.engine.launch.memory import Memory
from vtk_mls.engine.launch.structs import filled
from vtk_mls.engine.map.coarse_map import CoarseMap
from vtk_mls.engine.map.cut_tables import NO_CUTS, cut_tables
from vtk_mls.engine.map.handle_tables import map_tables
from vtk_mls.engine.map.origin_nodes import OriginNodes

# Control points times functions times points of one launch: some tenths of a second on two CPU
# cores, so that progress is reported and an abort takes effect.
_MAX_WORK = 3e8
_POINTS_OF_SEGMENT = 4  # control points that take as long as a segment
# Points whose source indices stay in the cache of a CPU between the two kernels of a resampling.
_MAX_CACHED_POINTS = 1 << 19
# Structs of kernels that do not use them.
_FLOAT64 = (("USE_FP64", 1),)
_STEP_FILES = "one_step.cl", "steps.cl"
_NO_CUTS, _NO_NODES, _NO_CELLS = map(filled, ("cut_params_t", "nodes_t", "coarse_t"))
# Points of one search for forward images.
_MAX_SEARCHED_POINTS = 1 << 18


class Launcher:
    """Launches kernels on one device.

    Attributes
    ----------
    device : Device
    memory : Memory
    lattices : WeakKeyDictionary
        Lattices of the inverse by Region, for as long as deformations exist.
    """

    def __init__(self, device):
        self.device, self.memory = device, Memory(device)
        self._kernels = {}
        self._uploaded = weakref.WeakKeyDictionary()  # control points -> buffer, starts
        self.lattices = weakref.WeakKeyDictionary()

    # Slices of the work

    def slabs(self, count, deformation, bytes_per_item, max_count=None):
        """Slices of `count` items, each within the limits of memory and of work."""
        cost = max(
            (len(c) + _POINTS_OF_SEGMENT * len(c.handles.segments)) * (1 + c.kind.functions(c))
            for c in (region.control_points for region in deformation.regions)
        )
        cost *= deformation.steps_used
        if deformation.map_tolerance > 0:
            cost /= 4  # most points are interpolated, as a rule
        limit = min(
            _MAX_WORK / cost,
            self.memory.limit / 4 / bytes_per_item,
            self.device.handle.max_mem_alloc_size / bytes_per_item,
            max_count or count,
        )
        step = max(1024, int(limit) // 1024 * 1024)
        return [slice(start, min(count, start + step)) for start in range(0, count, step)]

    def sampled_slabs(self, count, deformation, bytes_per_item):
        """Slabs of `count` points of a grid at which arrays are sampled."""
        max_count = _MAX_CACHED_POINTS if self.memory.in_place else None
        return self.slabs(count, deformation, bytes_per_item, max_count)

    def search_slabs(self, count, deformation):
        """Slabs of `count` points whose forward images are searched for."""
        return self.slabs(count, deformation, 64, _MAX_SEARCHED_POINTS)

    # Kernels

    def launch(self, name, constants, count, *arguments):
        """Launch a kernel for `count` points."""
        cached = self._kernels.get((name, constants))
        if cached is None:
            kernel = devices.kernel(self.device, name, constants)
            cached = self._kernels[name, constants] = kernel, dict(constants)["LANES"]
        kernel, lanes = cached
        items = -(-count // lanes)
        local = 64 if self.device.kind == "gpu" else 16
        kernel(self.memory.queue, (-(-items // local) * local,), (local,), *arguments)

    def sums(self, double):
        """Build constants of kernels that sum in double or in float."""
        if double:
            return [("LANES", self.device.double_lanes), *_FLOAT64]
        return [("LANES", self.device.lanes)]

    def map(self, deformation, region, grid, second_pass):
        """Build constants and shared kernel arguments of the map in a region."""
        control_points, alpha = region.control_points, deformation.alpha
        kind, steps = control_points.kind, control_points.steps(deformation.steps_used)
        handles = control_points.handles
        tables, starts = self._map_tables(deformation, control_points)
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
        constants = [
            ("TWICE_ALPHA", int(2 * alpha) if 2 * alpha in (1, 2, 3, 4, 6) else 0),
            ("FIT", kind.kernel),
            *_feature("REGION", "regions", handles.proxy_count),
            *_feature("SEGMENT", "segments", kind.segment_points * bool(len(handles.segments))),
            *_feature("LIMIT", "limits", bool(deformation.limits)),
            *(("STEPS", int(len(steps) > 1)), ("STEP_FILE", _STEP_FILES[len(steps) > 1])),
            ("LANES", self.device.lanes),
            *(_FLOAT64 if self.device.has_float64 and kind.needs_float64(alpha) else ()),
            *kind.constants().items(),
        ]
        of_cuts, cut_params, cut_table = NO_CUTS, _NO_CUTS, None
        if deformation.cuts:
            of_cuts, cut_params, table = cut_tables(deformation, region, grid, second_pass)
            cut_table = self.memory.constant(table)
        return (*constants, *of_cuts), [params, tables, cut_params, cut_table]

    def _map_tables(self, deformation, control_points):
        """A buffer of the `map_tables`, uploaded once, and where each begins."""
        if control_points not in self._uploaded:
            table, starts = map_tables(deformation, control_points)
            self._uploaded[control_points] = self.memory.constant(table), starts
        return self._uploaded[control_points]


class RegionMap:
    """The map of a deformation in one region, as the kernels evaluate it.

    Attributes
    ----------
    region : Region
    control_points : ControlPoints
        Of the region; their local frame is that of the kernels.
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
        # by a weak reference, so that the memory of nodes is free as soon as the map is gone
        self._nodes = OriginNodes(weakref.proxy(self)) if searches else None
        # Without searches a GPU evaluates the map at least as fast as it interpolates: an NVIDIA
        # H200, 64^3 to 256^3, 15 to 5,000 control points, 1 and 16 steps, takes 0.4 to 1 times.
        is_fast = launcher.device.kind == "gpu" and not deformation.obstacles
        has_nodes = deformation.map_tolerance > 0 and not is_fast
        self._coarse_map = CoarseMap(weakref.proxy(self)) if has_nodes else None

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
        # limits are applied between nodes to displacements only, and only to those of one step
        is_unlimited = self.deformation.steps_used > 1 or name == "grid_covariant"
        exactly = second_pass or (self.deformation.limits and is_unlimited)
        if coarsely and not exactly and self._coarse_map and self._coarse_map.pays_off(grid):
            return self._coarse_map.launch(name, grid, part, *arguments, constants=constants)
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
        nodes = self._nodes.around(grid, part) if self._nodes else [_NO_NODES, None]
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
        frame = kernel_arguments.local_frame(center)
        density = float_type(1 / self.control_points.scale)
        constants = [("LANES", device.lanes), ("VALUE", array_types.c_type(points))]
        if device.has_float64:
            constants.append(("USE_FP64", 1))
        memory, points = self.memory, np.ascontiguousarray(points)
        with memory.input_buffer(points) as x, memory.output_buffer(local) as out:
            self.launcher.launch(
                "local_points",
                tuple(constants),
                len(points),
                np.int64(len(points)),
                x,
                frame,
                density,
                out,
            )
        return local

    def launch(self, name, grid_and_pass, count, *arguments, constants=()):
        """Launch a kernel of the map, for a whole grid or None and the first or second pass."""
        if grid_and_pass not in self._shared_arguments:
            shared = self.launcher.map(self.deformation, self.region, *grid_and_pass)
            self._shared_arguments[grid_and_pass] = shared
        map_constants, shared = self._shared_arguments[grid_and_pass]
        self.launcher.launch(name, (*map_constants, *constants), count, *shared, *arguments)


def _feature(name, file, value):
    """Build constants of a feature: its value or 0, and its file or that of its absence."""
    return (f"{name}S", int(value)), (f"{name}_FILE", f"{file}.cl" if value else f"no_{file}.cl")
