"""An interactive editor of deformations for any VTK window."""

from vtk_mls.base import lazy

TYPE_CHECKING = False  # as type checkers understand it
if TYPE_CHECKING:
    from vtk_mls.editor.editor import Editor
    from vtk_mls.editor.state import State

__all__ = ["Editor", "State"]

_MODULES = {"Editor": "editor", "State": "state"}
__getattr__, __dir__ = lazy.names(__name__, _MODULES)
