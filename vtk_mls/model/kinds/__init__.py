"""The kinds of maps. Each file of this folder defines a family, which is found by import."""

from vtk_mls.base.lazy import classes_in
from vtk_mls.model.kinds.kind import Kind

_found = [kind for kind in classes_in(__name__, __path__, Kind) if kind.name]
BY_NAME = {kind.name: kind for kind in sorted(_found, key=lambda kind: (kind.equation, kind.name))}
KINDS = tuple(name for name, kind in BY_NAME.items() if kind.is_local)  # of the paper
ALL_KINDS = tuple(BY_NAME)
