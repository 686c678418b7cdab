"""Plug-in classes: those that the files of a folder define."""

from importlib import import_module
from pkgutil import iter_modules
from typing import TypeVar

T = TypeVar("T")


def classes_in(package, path, base):
    """The subclasses of `base` that the modules of a package define."""
    modules = [import_module(module.name) for module in iter_modules(path, f"{package}.")]
    return [
        member
        for module in modules
        for member in vars(module).values()
        if isinstance(member, type) and issubclass(member, base)
        if member.__module__ == module.__name__
    ]
