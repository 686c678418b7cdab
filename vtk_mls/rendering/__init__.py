"""What is deformed, drawn while it moves: nothing is resampled."""

from importlib import import_module

__all__ = ["DeformedMesh", "DeformedVolume", "RenderingError"]

_MODULES = {
    "DeformedMesh": "deformed_mesh",
    "DeformedVolume": "deformed_volume",
    "RenderingError": "errors",
}


def __getattr__(name):
    if name not in _MODULES:
        raise AttributeError(f"module `vtk_mls.rendering` has no attribute `{name}`")
    globals()[name] = getattr(import_module(f"vtk_mls.rendering.{_MODULES[name]}"), name)
    return globals()[name]


def __dir__():
    return sorted({*globals(), *__all__})
