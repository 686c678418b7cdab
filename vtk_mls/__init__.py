"""Interactive moving-least-squares deformation of volumes and meshes, computed by OpenCL."""

from vtk_mls import lazy

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.cuts import HalfPlane, Plane, Surface
    from vtk_mls.deformation import Deformation, DisplacementField, ForwardField
    from vtk_mls.engine.device import DeviceError
    from vtk_mls.grid import Grid
    from vtk_mls.interpolation import INTERPOLATIONS
    from vtk_mls.kinds import KINDS
    from vtk_mls.options import CUT_FRAMES
    from vtk_mls.progress import Aborted
    from vtk_mls.sampling import VOID_VALUES, Sampling
    from vtk_mls.void_cells import VoidCells

__all__ = [
    "CUT_FRAMES",
    "INTERPOLATIONS",
    "KINDS",
    "VOID_VALUES",
    "Aborted",
    "Deformation",
    "DeviceError",
    "DisplacementField",
    "ForwardField",
    "Grid",
    "HalfPlane",
    "Plane",
    "Sampling",
    "Surface",
    "VoidCells",
]
__version__ = "0.1.0"

# Modules are imported when a name is first used: the command must be able to answer Ctrl-C before
# numpy is loaded.
_MODULES = {
    "CUT_FRAMES": "options",
    "INTERPOLATIONS": "interpolation",
    "KINDS": "kinds",
    "VOID_VALUES": "sampling",
    "Aborted": "progress",
    "Deformation": "deformation",
    "DeviceError": "engine.device",
    "DisplacementField": "deformation",
    "ForwardField": "deformation",
    "Grid": "grid",
    "HalfPlane": "cuts",
    "Plane": "cuts",
    "Sampling": "sampling",
    "Surface": "cuts",
    "VoidCells": "void_cells",
}
_ROOMS = ("editor", "files", "filters", "io", "pyvista", "rendering")
__getattr__, __dir__ = lazy.names(__name__, _MODULES, _ROOMS)
