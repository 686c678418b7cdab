"""First uses: packages import a module at the first use of one of its names (PEP 562), and
functions make a value that all threads share."""

import functools
import sys
import threading
from importlib import import_module

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
