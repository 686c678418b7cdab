"""First uses: packages import a module at the first use of one of its names (PEP 562), and
functions make a value that all threads share. Packages find the classes of their modules."""

import functools
import sys
import threading
from importlib import import_module
from pkgutil import iter_modules

_lock = threading.RLock()  # one for all, since cached functions call each other


def cached(function):
    """As `functools.cache`, but one thread makes a value, and the others wait for it.

    An exception is not cached.
    """
    values = {}

    @functools.wraps(function)
    def value(*arguments):
        if arguments not in values:
            with _lock:
                if arguments not in values:
                    values[arguments] = function(*arguments)
        return values[arguments]

    value.cache_clear = values.clear
    return value


def names(package, modules, rooms=()):
    """The functions `__getattr__` and `__dir__` of a package.

    `modules` are modules of the package by the public names that they define, `rooms` modules that
    are public names themselves.
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
