"""VTK filters: ports and properties over `vtk_mls.Deformation`."""

from importlib import import_module

# Types of these are in __init__.pyi.
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
