"""The target that the moving data are to match, and how both are compared."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

MODES = BESIDE, FADE, CHECKERBOARD, DIFFERENCE = "beside", "fade", "checkerboard", "difference"


@dataclass(frozen=True, eq=False)
class Target:
    """An image or a mesh, and its file, beside the moving data in the same world coordinates.

    If it `is_upload`, the file will be deleted, and sessions copy it.
    """

    dataset: Any
    path: Any = None
    is_upload: bool = False

    def __post_init__(self):
        if not self.dataset.IsA("vtkDataSet"):
            raise TypeError(
                f"`target` must be a single image or mesh, got a {self.dataset.GetClassName()}"
            )

    @property
    def name(self):
        """The name of the file."""
        return "target" if self.path is None else Path(self.path).name


@dataclass(frozen=True)
class Comparison:
    """How the moving data and the target are drawn: one of `MODES`, and the target's share in FADE.

    All modes but BESIDE draw them over each other.
    """

    mode: str = BESIDE
    share: float = 0.5

    def __post_init__(self):
        if self.mode not in MODES:
            raise ValueError(f"`mode` must be one of {', '.join(MODES)}, got {self.mode!r}")
        if not 0 <= self.share <= 1:
            raise ValueError(f"`share` must be a number from 0 to 1, got {self.share!r}")
