"""Lazy imports: packages import a module at the first use of one of its names (PEP 562)."""

import sys
from importlib import import_module


def names(package, modules, rooms=()):
    """The functions `__getattr__` and `__dir__` of a package.

    Parameters
    ----------
    package : str
    modules : dict
        Modules of the package by the public names that they define.
    rooms : tuple of str, optional
        Modules of the package that are public names themselves.
    """
    namespace = vars(sys.modules[package])

    def get(name):
        if name in rooms:
            return import_module(f"{package}.{name}")
        if name not in modules:
            raise AttributeError(f"module `{package}` has no attribute `{name}`")
        namespace[name] = getattr(import_module(f"{package}.{modules[name]}"), name)
        return namespace[name]

    def listed():
        return sorted({*namespace, *modules, *rooms})

    return get, listed
