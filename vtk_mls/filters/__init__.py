"""VTK filters: ports and properties over `vtk_mls.Deformation`."""

from importlib import import_module

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.filters.control_points import MLSControlPoints
    from vtk_mls.filters.deform import MLSDeform
    from vtk_mls.filters.displacement_field import MLSDisplacementField

__all__ = ["MLSControlPoints", "MLSDeform", "MLSDisplacementField"]

# Modules are imported when a name is first used: the command reads the tables of properties, and
# must be able to say that there is no VTK.
_MODULES = {
    "MLSControlPoints": "control_points",
    "MLSDeform": "deform",
    "MLSDisplacementField": "displacement_field",
}


def __getattr__(name):
    if name not in _MODULES:
        raise AttributeError(f"module `vtk_mls.filters` has no attribute `{name}`")
    globals()[name] = getattr(import_module(f"vtk_mls.filters.{_MODULES[name]}"), name)
    return globals()[name]


def __dir__():
    return sorted({*globals(), *__all__})
