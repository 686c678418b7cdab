"""Volumes and meshes that are drawn deformed, without resampling."""

from importlib import import_module

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.rendering.deformed_mesh import DeformedMesh
    from vtk_mls.rendering.deformed_volume import DeformedVolume
    from vtk_mls.rendering.volume_checks import RenderingError

__all__ = ["DeformedMesh", "DeformedVolume", "RenderingError"]

_MODULES = {
    "DeformedMesh": "deformed_mesh",
    "DeformedVolume": "deformed_volume",
    "RenderingError": "volume_checks",
}


def __getattr__(name):
    """Import the module of a public name at its first use: VTK's rendering modules load slowly."""
    if name not in _MODULES:
        raise AttributeError(f"module `{__name__}` has no attribute `{name}`")
    value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *__all__})
