"""Who may import whom: one room for one dependency, and no circles."""

import ast
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "vtk_mls"

# What each room may import: other rooms, and packages from outside. A module that lies in no folder
# is in "core" unless it has a line of its own, here or in SAME_ROOM.
ROOMS = {
    "core": {"kinds", "cuts", "engine", "numpy"},
    "kinds": {"core", "numpy"},
    "cuts": {"core", "numpy"},
    "engine": {"core", "kinds", "numpy", "pyopencl"},
    "arrays": {"core", "numpy", "vtkmodules"},
    "files": {"core", "arrays", "meshio", "numpy", "vtkmodules"},
    "filters": {"core", "arrays", "files", "numpy", "vtkmodules"},
    "rendering": {"core", "cuts", "engine", "arrays", "filters", "numpy", "vtkmodules"},
    "io": {"core", "cuts", "arrays", "files", "filters", "vtkmodules"},
    "editor": {
        *{"core", "kinds", "cuts", "engine", "arrays", "files", "filters", "io", "rendering"},
        *{"numpy", "vtkmodules"},
    },
    "pyvista": {
        *{"core", "arrays", "files", "filters", "io", "editor"},
        *{"numpy", "vtkmodules"},
    },
    "web": {
        *{"core", "kinds", "cuts", "arrays", "files", "io", "rendering", "editor"},
        *{"aiohttp", "numpy", "trame", "trame_client", "vtkmodules"},
    },
    "paraview": {
        *{"core", "arrays", "files", "filters", "io", "rendering", "editor"},
        *{"numpy", "paraview", "vtkmodules"},
    },
    "commands": {
        *{"core", "engine", "arrays", "files", "filters", "io", "paraview", "editor"},
        "web",
        *{"numpy", "vtkmodules"},
    },
}
SAME_ROOM = {"__main__": "commands", "cli": "commands", "doctor": "commands"}
# The only door of the core to the engines.
DISPATCH = "engine.dispatch"


def modules():
    """Every module of the package by its dotted name within."""
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        yield ".".join(parts), path


NAMES = {name.removesuffix(".__init__") for name, _ in modules()}


def room(name):
    """The room of the module `name`."""
    first, inner, _ = name.partition(".")
    first = SAME_ROOM.get(first, first)
    return first if inner or first in ROOMS else "core"


def imported(text, everywhere=True):
    """Modules of the package ("__init__" for public names) that are imported; others outside it.

    With `everywhere`, also within functions.
    """
    tree = ast.parse(text)
    inside, outside = set(), set()
    for node in ast.walk(tree) if everywhere else tree.body:
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in found:
            first, _, rest = name.partition(".")
            if first != "vtk_mls":
                outside.add(first)
                continue
            while rest and rest not in NAMES:
                rest = rest.rpartition(".")[0]
            inside.add(rest or "__init__")
    return inside, outside - set(sys.stdlib_module_names) - {"__future__"}


@pytest.mark.parametrize(("name", "path"), [*modules()], ids=[name for name, _ in modules()])
def test_only_the_agreed_imports(name, path):
    inside, outside = imported(path.read_text())
    here = room(name)
    extra = (({room(each) for each in inside} | outside) - {here}) - ROOMS[here]
    assert not extra, f"{name} must not import {', '.join(sorted(extra))}"
    if here == "core":
        others = {each for each in inside if room(each) == "engine"}
        assert others <= {DISPATCH} or name == "__init__", f"{name} must not import {others}"


def test_no_circles():
    """Rooms may look into each other where modules do not: core asks engines, which know it."""
    todo = {name: imported(path.read_text(), everywhere=False)[0] for name, path in modules()}
    todo = {name.removesuffix(".__init__"): needs for name, needs in todo.items()}
    todo["__init__"] = set()  # imports when a name is first used
    while todo:
        done = {name for name, needs in todo.items() if not (needs & todo.keys()) - {name}}
        assert done, f"these import each other: {', '.join(sorted(todo))}"
        todo = {name: needs for name, needs in todo.items() if name not in done}


def test_the_test_sees_a_forbidden_import():
    inside, outside = imported("from vtk_mls.engine.engine import Engine\nimport os, vtk")
    assert (inside, outside) == ({"engine.engine"}, {"vtk"})
    assert room("engine.engine") == "engine"
    assert imported("from vtk_mls import Deformation, io")[0] == {"__init__", "io"}
    assert (room("io"), room("__init__"), room("grid")) == ("io", "core", "core")
