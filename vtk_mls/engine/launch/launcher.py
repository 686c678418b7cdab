"""Kernels of an OpenCL device: built at their first use, launched in slabs."""

import weakref

from vtk_mls.engine.device import devices
from vtk_mls.engine.launch.memory import Memory

# Control points times functions times points of one launch: some tenths of a second on two CPU
# cores, so that progress is reported and an abort takes effect.
_MAX_WORK = 3e8
_POINTS_OF_SEGMENT = 4  # control points that take as long as a segment
FLOAT64 = (("USE_FP64", 1),)  # build constants


class Launcher:
    """Launches kernels on one device.

    `tables` has buffers with the tables of a map by ControlPoints, and `lattices` lattices of the
    inverse by Region, for as long as deformations exist.
    """

    def __init__(self, device):
        self.device, self.memory = device, Memory(device)
        self.tables, self.lattices = weakref.WeakKeyDictionary(), weakref.WeakKeyDictionary()

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

    def launch(self, name, constants, count, *arguments):
        """Launch a kernel for `count` points."""
        kernel = devices.kernel(self.device, name, constants)
        items = -(-count // dict(constants)["LANES"])
        local = 64 if self.device.kind == "gpu" else 16
        kernel(self.memory.queue, (-(-items // local) * local,), (local,), *arguments)

    def sums(self, double):
        """Build constants of kernels that sum in double or in float."""
        if double:
            return [("LANES", self.device.double_lanes), *FLOAT64]
        return [("LANES", self.device.lanes)]
