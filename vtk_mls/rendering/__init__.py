"""What is deformed, drawn while it moves: nothing is resampled."""

from vtk_mls.base import lazy

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.rendering.deformed_mesh import DeformedMesh
    from vtk_mls.rendering.deformed_volume import DeformedVolume
    from vtk_mls.rendering.errors import RenderingError

__all__ = ["DeformedMesh", "DeformedVolume", "RenderingError"]

# Modules are imported when a name is first used: VTK's for rendering take a while.
_MODULES = {
    "DeformedMesh": "deformed_mesh",
    "DeformedVolume": "deformed_volume",
    "RenderingError": "errors",
}
__getattr__, __dir__ = lazy.names(__name__, _MODULES)
