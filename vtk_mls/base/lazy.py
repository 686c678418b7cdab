"""Packages that import their modules when a name of them is first used."""

import sys
from importlib import import_module


def names(package, modules, rooms=()):
    """What a package must have as `__getattr__` and `__dir__`.

    Parameters
    ----------
    package : str
    modules : dict
        Where in the package each of its public names is defined.
    rooms : tuple of str, optional
        Modules of the package that are names of it, too.
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
