"""What is public is annotated and in the reference; engines have the same interface.

`make types` checks the annotations, with `typed_program.py`.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from pkgutil import resolve_name

import pytest

import vtk_mls
from vtk_mls import io, landmarks, rendering
from vtk_mls.engine import opencl_engine as engine
from vtk_mls.engine import protocol
from vtk_mls.files import field_files
from vtk_mls.reference import reference_engine as reference

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "api.md"
PUBLIC = (
    "vtk_mls",
    *(f"vtk_mls.{room}" for room in ("cuts", "dask", "editor", "filters", "io", "landmarks")),
)
PUBLIC += ("vtk_mls.pyvista", "vtk_mls.rendering")


def listed(text):
    """The names, with their modules, that lists of the page have; and modules and other names."""
    names = set()
    for module, body in re.findall(r"currentmodule:: (\S+)\n(.*?)```", text, re.DOTALL):
        names |= {module} | {f"{module}.{name}" for name in re.findall(r"^   (\w+)$", body, re.M)}
    return names | set(re.findall(r"`(vtk_mls[\w.]+)`", text))


@pytest.mark.parametrize("module", PUBLIC)
def test_what_is_public_is_in_the_reference(module):
    pytest.importorskip("pyvista")
    there = {id(resolve_name(name)) for name in listed(PAGE.read_text(encoding="utf-8"))}
    public = resolve_name(module)
    missing = [name for name in public.__all__ if id(getattr(public, name)) not in there]
    assert not missing, f"docs/reference/api.md lacks {missing} of {module}"


def public():
    """(name, function) of each public function and method that users call."""
    for module in (vtk_mls, rendering, io, landmarks, field_files):
        for name in getattr(module, "__all__", vars(module)):
            value = getattr(module, name)
            is_own = getattr(value, "__module__", None) == module.__name__
            if inspect.isclass(value) and (is_own or module in (vtk_mls, rendering, landmarks)):
                yield from methods(value)
            elif inspect.isfunction(value) and is_own and not name.startswith("_"):
                yield f"{module.__name__}.{name}", value


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


def questions(answers):
    """The names and kinds of the parameters of each public function of an engine, but self."""
    module = answers.__name__ if inspect.ismodule(answers) else answers.__module__
    functions = {
        name: inspect.signature(value).parameters.values()
        for name, value in vars(answers).items()
        if inspect.isfunction(value) and value.__module__ == module and name[0] != "_"
    }
    return {
        name: [(p.name, p.kind) for p in parameters if p.name != "self"]
        for name, parameters in functions.items()
    }


@pytest.mark.parametrize("answers", [reference, engine.Engine], ids=["reference", "OpenCL"])
def test_engines_keep_to_the_protocol(answers):
    assert len(questions(protocol.Engine)) > 10
    assert questions(answers) == questions(protocol.Engine)
