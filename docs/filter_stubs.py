"""Types of the filters for editors and type checkers, which do not see methods made from tables."""

from __future__ import annotations

import inspect
from pathlib import Path

from vtk_mls import filters
from vtk_mls.filters import properties
from vtk_mls.filters.deforming import DeformingFilter

STUBS = Path(filters.__file__).with_name("__init__.pyi")
HEAD = '''"""Written by `python docs/properties_page.py` from the tables of properties."""

from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal

from numpy.typing import ArrayLike
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.base.grid import Grid
from vtk_mls.model.cuts import Cut
from vtk_mls.model.handles.handle_set import Handle
from vtk_mls.model.limits import FixedFace, Mask
from vtk_mls.queries.transform import Transform

'''
# What an algorithm of VTK has anyway, or what is not for users.
INHERITED = ("ProcessRequest", "Request", "FillInputPortInformation", "is_")
# Types of values of `vtk_mls`, by the names of their properties.
_VALUES = {
    "Cuts": "Cut",
    "Handles": "Handle",
    "Constraints": "FixedFace",
    "Reference": "Grid | vtkImageData | None",
    "Mask": "Mask | vtkImageData | None",
    "InitialTransform": "Transform | str | PathLike[str] | None",
}


def stubs():
    """The text of the stubs."""
    return HEAD + "\n".join(
        [
            _class("_DeformingFilter", DeformingFilter, "VTKPythonAlgorithmBase"),
            *(_public_class(getattr(filters, name)) for name in filters.__all__),
        ]
    )


def _public_class(kind):
    if issubclass(kind, DeformingFilter):
        inherited = _methods(DeformingFilter).values()
        return _class(kind.__name__, kind, "_DeformingFilter", inherited)
    return _class(kind.__name__, kind, "VTKPythonAlgorithmBase")


def _class(name, kind, base, inherited=()):
    """A class with the methods of `kind`, except those that are `inherited`."""
    lines = [f"class {name}({base}):", "    def __init__(self) -> None: ..."]
    properties_of = {method: prop for prop in kind.PROPERTIES for method in prop.methods()}
    for method_name, method in _methods(kind).items():
        prop = properties_of.get(method_name)
        if method not in inherited:
            lines.append(_property_method(prop, method) if prop else _method(method))
    return "\n".join(lines) + "\n"


def _methods(kind):
    """The methods for users by their names, first those of properties."""
    methods = {name: getattr(kind, name) for prop in kind.PROPERTIES for name in prop.methods()}
    for base in reversed(kind.__mro__):
        if base.__module__.startswith("vtk_mls"):
            for name, method in vars(base).items():
                if inspect.isfunction(method) and not name.startswith(("_", *INHERITED)):
                    methods[name] = getattr(kind, name)
    return methods


def _property_method(prop, method):
    """A method of a property, with its help if it has all of it."""
    name = method.__name__
    gives = "int" if "NumberOf" in name else _type_of(prop)
    result = gives if name.startswith("Get") else "None"
    taken = {"self": "", **_types_taken(prop)}
    parameters = [
        f"{parameter}: {taken[parameter.name]}".removesuffix(": ")
        for parameter in inspect.signature(method).parameters.values()
    ]
    if parameters[-1] == "*row: float" and len(prop.columns) <= 3:
        parameters[-1:] = [f"{column}: float" for column in prop.columns]
    head = f"    def {name}({', '.join(parameters)}) -> {result}:"
    if " ".join(prop.help.split()) not in " ".join(method.__doc__.split()):
        return f"{head} ..."
    text = method.__doc__.replace("\n", "\n        ").replace("        \n", "\n")
    end = "\n        " if "\n" in text else ""
    return f'{head}\n        """{text}{end}"""\n'


def _method(method):
    names = ", ".join(map(str, inspect.signature(method).parameters.values()))
    return f"    def {method.__name__}({names}) -> Any: ..."


def _types_taken(prop):
    """Types of what setters are given, by the names of their parameters."""
    value = _VALUES.get(prop.name) or _type_of(prop)
    if isinstance(prop, properties.Choice):
        value = f"Literal[{', '.join(repr(choice) for choice in prop.choices)}]".replace("'", '"')
    elif isinstance(prop, properties.ArrayNames):
        value = "str"
    elif isinstance(prop, properties.Text) and prop.name not in _VALUES:
        value = "str | None"
    return {
        "value": value,
        "values": "ArrayLike" if isinstance(prop, properties.Rows) else "float | Sequence[float]",
        "index": "int",
        "count": "int",
        "row": "float",
    }


def _type_of(prop):
    """The type of the value of a property."""
    types = {
        properties.TransformFile: "Transform | str | PathLike[str]",
        properties.Flag: "bool",
        properties.Choice: "str",
        properties.Text: "str",
        properties.ArrayNames: "tuple[str, ...]",
        properties.Values: f"tuple[{_VALUES.get(prop.name)}, ...]",
        properties.Value: _VALUES.get(prop.name),
        properties.Positions: "tuple[tuple[float, float, float], ...]",
        properties.Planes: "tuple[tuple[float, ...], ...]",
        properties.Factors: "tuple[float, ...]",
        properties.Number: type(prop.default).__name__,
    }
    if isinstance(prop, properties.Vector):
        return f"tuple[{type(prop.default[0]).__name__}, ...]"
    return next(name for kind, name in types.items() if isinstance(prop, kind))
