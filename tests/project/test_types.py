"""The public API is annotated as a whole; `make types` checks it, with `typed_program.py`."""

from __future__ import annotations

import inspect

import vtk_mls
from vtk_mls import io, landmarks, rendering
from vtk_mls.files import field_files


def public():
    """(name, function) of each public function and method that users call."""
    for module in (vtk_mls, rendering, io, landmarks, field_files):
        for name in getattr(module, "__all__", vars(module)):
            value = getattr(module, name)
            if inspect.isclass(value) and (
                module in (vtk_mls, rendering, landmarks) or value.__module__ == module.__name__
            ):
                yield from methods(value)
            elif is_own_function(module, name):
                yield f"{module.__name__}.{name}", value


def is_own_function(module, name):
    """Whether a public function is of a module, and not imported."""
    value = getattr(module, name)
    is_own = inspect.isfunction(value) and value.__module__ == module.__name__
    return is_own and not name.startswith("_")


def methods(kind):
    """(name, function) of what a class of the package defines itself for users."""
    for base in kind.__mro__:
        if not base.__module__.startswith("vtk_mls"):
            continue
        for name, value in vars(base).items():
            if isinstance(value, property):
                value = value.fget
            value = inspect.unwrap(getattr(value, "__func__", value))
            if inspect.isfunction(value) and not name.startswith("_"):
                yield f"{kind.__name__}.{name}", value


def lacking(function):
    """What of a function has no annotation."""
    signature = inspect.signature(function)
    found = [
        name
        for name, parameter in signature.parameters.items()
        if parameter.annotation is parameter.empty and name not in ("self", "cls")
    ]
    return found + ["return"] * (signature.return_annotation is signature.empty)


def test_every_public_function_is_annotated():
    found = {name: lacking(function) for name, function in public()}
    assert len(found) > 40
    assert not {name: missing for name, missing in found.items() if missing}
