"""VTK filters: ports and properties over `vtk_mls.Deformation`."""

from vtk_mls.filters.control_points import MLSControlPoints
from vtk_mls.filters.deform import MLSDeform
from vtk_mls.filters.displacement_field import MLSDisplacementField

__all__ = ["MLSControlPoints", "MLSDeform", "MLSDisplacementField"]
