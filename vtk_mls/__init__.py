"""Interactive moving-least-squares deformation of volumes and meshes, computed by OpenCL."""

from vtk_mls.base import lazy

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.base.grid import Grid
    from vtk_mls.base.interpolation import INTERPOLATIONS
    from vtk_mls.base.progress import Aborted
    from vtk_mls.base.sampling import VOID_VALUES, Sampling
    from vtk_mls.deformation import Deformation
    from vtk_mls.engine.device.devices import DeviceError
    from vtk_mls.model.cuts import HalfPlane, Plane, Surface
    from vtk_mls.model.handles.curve import CurveHandle
    from vtk_mls.model.handles.region import RegionHandle
    from vtk_mls.model.handles.shapes import Ball, Capsule, Labels, Solid
    from vtk_mls.model.kinds import KINDS
    from vtk_mls.model.limits import BallMask, BoxMask, FixedFace, ImageMask, SlidingFace
    from vtk_mls.model.options import CUT_FRAMES
    from vtk_mls.queries.certificate import Certificate
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
    "Certificate",
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
    "KINDS": "model.kinds",
    "VOID_VALUES": "base.sampling",
    "Aborted": "base.progress",
    "Affine": "transforms.affine",
    "Ball": "model.handles.shapes",
    "BallMask": "model.limits",
    "BoxMask": "model.limits",
    "Capsule": "model.handles.shapes",
    "Certificate": "queries.certificate",
    "Chain": "transforms.chain",
    "CurveHandle": "model.handles.curve",
    "Deformation": "deformation",
    "DeviceError": "engine.device.devices",
    "DisplacementField": "queries.fields",
    "Field": "transforms.field",
    "FixedFace": "model.limits",
    "ForwardField": "queries.fields",
    "Grid": "base.grid",
    "HalfPlane": "model.cuts",
    "ImageMask": "model.limits",
    "Labels": "model.handles.shapes",
    "Plane": "model.cuts",
    "RegionHandle": "model.handles.region",
    "Sampling": "base.sampling",
    "SlidingFace": "model.limits",
    "Solid": "model.handles.shapes",
    "Surface": "model.cuts",
    "VoidCells": "queries.void_cells",
}
_ROOMS = ("cuts", "dask", "editor", "files", "filters", "io", "landmarks", "pyvista", "rendering")
__getattr__, __dir__ = lazy.names(__name__, _MODULES, _ROOMS)
