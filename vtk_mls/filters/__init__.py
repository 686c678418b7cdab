"""VTK filters: ports and properties over `vtk_mls.Deformation`."""

from vtk_mls.base import lazy

# Types of these are in __init__.pyi, which docs/filter_stubs.py writes.
__all__ = ["MLSControlPoints", "MLSDeform", "MLSDisplacementField", "MLSLandmarkReport"]

# Modules are imported when a name is first used: the command reads the tables of properties, and
# must be able to say that there is no VTK.
_MODULES = {
    "MLSControlPoints": "control_point_source",
    "MLSDeform": "deform",
    "MLSDisplacementField": "displacement_field",
    "MLSLandmarkReport": "landmark_report",
}
__getattr__, __dir__ = lazy.names(__name__, _MODULES)
