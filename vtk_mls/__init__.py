"""Interactive moving-least-squares deformation of volumes and meshes, computed by OpenCL."""

from vtk_mls.base import lazy

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.base.grid import Grid
    from vtk_mls.base.interpolation import INTERPOLATIONS
    from vtk_mls.base.progress import Aborted
    from vtk_mls.base.sampling import VOID_VALUES, Sampling
    from vtk_mls.cuts import HalfPlane, Plane, Surface
    from vtk_mls.deformation import Deformation
    from vtk_mls.engine.device.devices import DeviceError
    from vtk_mls.handles.curve import CurveHandle
    from vtk_mls.handles.region import RegionHandle
    from vtk_mls.handles.shapes import Ball, Capsule, Labels, Solid
    from vtk_mls.kinds import KINDS
    from vtk_mls.limits import BallMask, BoxMask, FixedFace, ImageMask, SlidingFace
    from vtk_mls.model.options import CUT_FRAMES
    from vtk_mls.queries.fields import DisplacementField, ForwardField
    from vtk_mls.queries.void_cells import VoidCells
    from vtk_mls.transforms.affine import Affine
    from vtk_mls.transforms.chain import Chain
    from vtk_mls.transforms.field import Field

__all__ = [
    "CUT_FRAMES",
    "INTERPOLATIONS",
    "KINDS",
    "VOID_VALUES",
    "Aborted",
    "Affine",
    "Ball",
    "BallMask",
    "BoxMask",
    "Capsule",
    "Chain",
    "CurveHandle",
    "Deformation",
    "DeviceError",
    "DisplacementField",
    "Field",
    "FixedFace",
    "ForwardField",
    "Grid",
    "HalfPlane",
    "ImageMask",
    "Labels",
    "Plane",
    "RegionHandle",
    "Sampling",
    "SlidingFace",
    "Solid",
    "Surface",
    "VoidCells",
]
__version__ = "0.2.0"

# Imported at the first use of a name: the command line must handle Ctrl-C before numpy is loaded.
_MODULES = {
    "CUT_FRAMES": "model.options",
    "INTERPOLATIONS": "base.interpolation",
    "KINDS": "kinds",
    "VOID_VALUES": "base.sampling",
    "Aborted": "base.progress",
    "Affine": "transforms.affine",
    "Ball": "handles.shapes",
    "BallMask": "limits",
    "BoxMask": "limits",
    "Capsule": "handles.shapes",
    "Chain": "transforms.chain",
    "CurveHandle": "handles.curve",
    "Deformation": "deformation",
    "DeviceError": "engine.device.devices",
    "DisplacementField": "queries.fields",
    "Field": "transforms.field",
    "FixedFace": "limits",
    "ForwardField": "queries.fields",
    "Grid": "base.grid",
    "HalfPlane": "cuts",
    "ImageMask": "limits",
    "Labels": "handles.shapes",
    "Plane": "cuts",
    "RegionHandle": "handles.region",
    "Sampling": "base.sampling",
    "SlidingFace": "limits",
    "Solid": "handles.shapes",
    "Surface": "cuts",
    "VoidCells": "queries.void_cells",
}
_ROOMS = ("editor", "files", "filters", "io", "landmarks", "pyvista", "rendering")
__getattr__, __dir__ = lazy.names(__name__, _MODULES, _ROOMS)
