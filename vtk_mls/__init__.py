"""Interactive moving-least-squares deformation of volumes and meshes, computed by OpenCL."""

from vtk_mls.base import lazy

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.base.grid import Grid as Grid
    from vtk_mls.base.interpolation import INTERPOLATIONS as INTERPOLATIONS
    from vtk_mls.base.progress import Aborted as Aborted
    from vtk_mls.base.sampling import VOID_VALUES as VOID_VALUES
    from vtk_mls.base.sampling import Sampling as Sampling
    from vtk_mls.deformation import Deformation as Deformation
    from vtk_mls.engine.device.devices import DeviceError as DeviceError
    from vtk_mls.model.cuts import HalfPlane as HalfPlane
    from vtk_mls.model.cuts import Plane as Plane
    from vtk_mls.model.cuts import Surface as Surface
    from vtk_mls.model.handles.curve import CurveHandle as CurveHandle
    from vtk_mls.model.handles.region import RegionHandle as RegionHandle
    from vtk_mls.model.handles.shapes import Ball as Ball
    from vtk_mls.model.handles.shapes import Capsule as Capsule
    from vtk_mls.model.handles.shapes import Labels as Labels
    from vtk_mls.model.handles.shapes import Solid as Solid
    from vtk_mls.model.kinds import KINDS as KINDS
    from vtk_mls.model.limits import BallMask as BallMask
    from vtk_mls.model.limits import BoxMask as BoxMask
    from vtk_mls.model.limits import FixedFace as FixedFace
    from vtk_mls.model.limits import ImageMask as ImageMask
    from vtk_mls.model.limits import SlidingFace as SlidingFace
    from vtk_mls.model.options import CUT_FRAMES as CUT_FRAMES
    from vtk_mls.queries.certificate import Certificate as Certificate
    from vtk_mls.queries.fields import DisplacementField as DisplacementField
    from vtk_mls.queries.fields import ForwardField as ForwardField
    from vtk_mls.queries.void_cells import VoidCells as VoidCells
    from vtk_mls.transforms.affine import Affine as Affine
    from vtk_mls.transforms.chain import Chain as Chain
    from vtk_mls.transforms.field import Field as Field

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
__all__ = [*_MODULES]
_ROOMS = ("cuts", "dask", "editor", "files", "filters", "io", "landmarks", "pyvista", "rendering")
__getattr__, __dir__ = lazy.names(__name__, _MODULES, _ROOMS)
