"""Interactive moving-least-squares deformation of volumes and meshes, computed by OpenCL."""

from vtk_mls.arguments import VOID_VALUES
from vtk_mls.cuts import HalfPlane, Plane, Surface
from vtk_mls.deformation import (
    Aborted,
    Deformation,
    DisplacementField,
    ForwardField,
)
from vtk_mls.device import DeviceError
from vtk_mls.grid import Grid
from vtk_mls.handles import KINDS
from vtk_mls.interpolation import INTERPOLATIONS

__all__ = [
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
    "Surface",
]
__version__ = "0.1.0"
