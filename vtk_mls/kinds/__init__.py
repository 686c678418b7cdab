"""The kinds of maps. Each file of this folder defines a family, which is found by import."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from vtk_mls.kinds.kind import Kind


def _find_kinds():
    """The kinds in all files of this folder, in the order of their equations and names."""
    modules = [import_module(module.name) for module in iter_modules(__path__, f"{__name__}.")]
    kinds = [
        member
        for module in modules
        for member in vars(module).values()
        if isinstance(member, type) and issubclass(member, Kind)
        if member.name and member.__module__ == module.__name__
    ]
    return sorted(kinds, key=lambda kind: (kind.equation, kind.name))


_KINDS = {kind.name: kind for kind in _find_kinds()}
KINDS = tuple(_KINDS)


def named(name, degree) -> Kind:
    """The kind `name`, one of `KINDS`; `degree` is that of polynomials."""
    return _KINDS[name](degree)
