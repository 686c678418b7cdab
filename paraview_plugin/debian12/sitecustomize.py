"""Lets Debian 12's ParaView 5.11 load Python plugins: put this folder on PYTHONPATH to start it.

ParaView 5.11 imports `inspect.getargspec`, which its own Python 3.11 does not have, so no
Python plugin loads.  This file restores the function and runs the next `sitecustomize` on the path,
which it hides.
"""

import importlib.util
import inspect
import os
import sys
from collections import namedtuple
from importlib.machinery import PathFinder

if not hasattr(inspect, "getargspec"):
    ArgSpec = namedtuple("ArgSpec", "args varargs keywords defaults")
    inspect.getargspec = lambda func: ArgSpec(*inspect.getfullargspec(func)[:4])

_here = os.path.dirname(os.path.abspath(__file__))
_others = [folder for folder in sys.path if os.path.abspath(folder) != _here]
_next = PathFinder.find_spec("sitecustomize", _others)
if _next is not None:
    _next.loader.exec_module(importlib.util.module_from_spec(_next))
