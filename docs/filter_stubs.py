"""Writes vtk_mls/filters/__init__.pyi, for type checkers do not see methods made from tables.

It is a build hook of the wheel and of editable installs (see pyproject.toml), without VTK. After
a change of a table: `make types`, or `python docs/filter_stubs.py`.
"""

from __future__ import annotations

import ast
import functools
import inspect
import sys
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PROJECT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PROJECT))  # the package is not installed yet

from vtk_mls import filters  # noqa: E402
from vtk_mls.filters import properties, property_tables  # noqa: E402

STUBS = "vtk_mls/filters/__init__.pyi"
HEAD = '''"""Written by `python docs/filter_stubs.py` from the tables of properties."""

from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal

from numpy.typing import ArrayLike
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.base.grid import Grid
from vtk_mls.model.cuts import Cut
from vtk_mls.model.handles.handle import Handle
from vtk_mls.model.limits import FixedFace, Mask
from vtk_mls.queries.transform import Transform

'''
# What an algorithm of VTK has anyway, or what is not for users.
INHERITED = ("ProcessRequest", "Request", "FillInputPortInformation", "is_", "_")
# Types of values of `vtk_mls`, by the names of their properties.
_VALUES = {
    "Cuts": "Cut",
    "Handles": "Handle",
    "Constraints": "FixedFace",
    "Reference": "Grid | vtkImageData | None",
    "Mask": "Mask | vtkImageData | None",
    "InitialTransform": "Transform | str | PathLike[str] | None",
}


class Types(BuildHookInterface):
    """Writes the file before a build, and puts it into the wheel."""

    def initialize(self, version, build_data):
        write()
        build_data["artifacts"].append(STUBS)


def write():
    """Write the file."""
    shared = _methods("DeformingFilter")
    classes = [_class("_DeformingFilter", "VTKPythonAlgorithmBase", shared)]
    for name in filters.__all__:
        methods = _methods(name)
        is_deforming = shared.keys() <= methods.keys()
        own = {key: text for key, text in methods.items() if text != shared.get(key)}
        base = "_DeformingFilter" if is_deforming else "VTKPythonAlgorithmBase"
        classes.append(_class(name, base, own if is_deforming else methods))
    (PROJECT / STUBS).write_text(HEAD + "\n".join(classes), encoding="utf-8")


def _class(name, base, methods):
    return (
        "\n".join(
            [f"class {name}({base}):", "    def __init__(self) -> None: ...", *methods.values()]
        )
        + "\n"
    )


def _methods(name):
    """The methods for users of a class of the filters by their names: read, not imported."""
    methods, node = {}, _classes().get(name)
    if node is None:
        return methods
    for base in reversed(node.bases):
        methods |= _methods(ast.unparse(base))
    for decorator in node.decorator_list:
        for row in getattr(property_tables, decorator.args[0].attr):
            made = properties.with_properties([row])(type(name, (), {}))
            methods |= {key: _property_method(row, getattr(made, key)) for key in row.methods()}
    for function in node.body:
        if isinstance(function, ast.FunctionDef) and not function.name.startswith(INHERITED):
            for argument in filter(None, [*function.args.args[1:], function.args.vararg]):
                argument.annotation = ast.Name("Any")
            text = f"({ast.unparse(function.args)}) -> Any: ..."
            methods[function.name] = f"    def {function.name}{text}"
    return methods


@functools.cache
def _classes():
    """The syntax trees of the classes of all modules of the filters, by name."""
    files = (PROJECT / STUBS).parent.glob("*.py")
    trees = [ast.parse(file.read_text(encoding="utf-8")) for file in files]
    return {
        node.name: node for tree in trees for node in tree.body if isinstance(node, ast.ClassDef)
    }


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


if __name__ == "__main__":
    write()
