"""The kinds of maps. A file of this room is a family of them, and is found by itself."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from vtk_mls.kinds.kind import Kind


def _found():
    """The kinds in all files of this room, in the order of the paper, then of their names."""
    found = []
    for module in iter_modules(__path__, f"{__name__}."):
        members = vars(import_module(module.name)).values()
        classes = [each for each in members if isinstance(each, type) and issubclass(each, Kind)]
        found += [each for each in classes if each.name and each.__module__ == module.name]
    return sorted(found, key=lambda kind: (kind.equation, kind.name))


_KINDS = {kind.name: kind for kind in _found()}
KINDS = tuple(_KINDS)


def named(name, degree) -> Kind:
    """The kind `name`, one of `KINDS`, with the `degree` of polynomials."""
    return _KINDS[name](degree)
