"""Volumes and meshes that are drawn deformed, without resampling."""

from vtk_mls.base import lazy

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.rendering.deformed_mesh import DeformedMesh
    from vtk_mls.rendering.deformed_volume import DeformedVolume
    from vtk_mls.rendering.shader import RenderingError

__all__ = ["DeformedMesh", "DeformedVolume", "RenderingError"]

# Imported at the first use of a name: VTK's rendering modules load slowly.
_MODULES = {
    "DeformedMesh": "deformed_mesh",
    "DeformedVolume": "deformed_volume",
    "RenderingError": "shader",
}
__getattr__, __dir__ = lazy.names(__name__, _MODULES)
