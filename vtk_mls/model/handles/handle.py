"""The interface of handles with an extent: regions and curves."""

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from vtk_mls.model.shape_fields import Described


class Handle(Described):
    """A handle with an extent."""

    title: ClassVar[str]  # in the editor

    @property
    def grips(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points (k, 3) by which the mouse drags it, at rest and deformed."""
        raise NotImplementedError

    def with_grips(self, deformed: NDArray[np.float64]) -> Any:
        """A copy with its deformed grips elsewhere (k, 3)."""
        raise NotImplementedError

    def blended(self, share: float) -> Any:
        """A copy with a `share` of its displacement: regions turn by that share of their angle."""
        raise NotImplementedError

    @property
    def is_resting(self) -> bool:
        """Whether it moves nothing."""
        raise NotImplementedError

    def samples(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points (n, 3) of it, at rest and deformed; `count` along each axis of a region."""
        raise NotImplementedError
