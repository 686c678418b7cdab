"""Who may import whom: one module per dependency boundary."""

import ast
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "vtk_mls"

# What each module may import of the package, and from outside of the standard library.
ALLOWED = {
    "__init__": {"arguments", "cuts", "deformation", "device", "grid", "handles", "interpolation"},
    "__main__": {"cli"},
    "arguments": {"cuts", "numpy"},
    "arrays": {"grid", "numpy", "vtkmodules"},
    "cli": {"", "demo", "doctor", "filters", "installation", "io", "resources", "vtkmodules"},
    "cut_tables": {"cuts", "numpy"},
    "cuts": {"numpy"},
    "deformation": {
        *{"arguments", "cuts", "dispatch", "fitting", "gradients", "grid", "handles"},
        *{"interpolation", "numpy", "regions"},
    },
    "demo": {"", "demo_volumes", "dispatch", "filters", "numpy", "vtkmodules"},
    "demo_cut": {"demo_scene", "numpy", "vtkmodules"},
    "demo_mesh": {"demo_picture", "demo_scene", "numpy", "tetgen", "vtkmodules"},
    "demo_picture": {"numpy", "vtkmodules"},
    "demo_scene": {"", "demo_picture", "demo_volumes", "filters", "numpy", "vtkmodules"},
    "demo_volumes": set(),
    "device": {"resources", "pyopencl"},
    "dispatch": {"device", "engine", "reference"},
    "doctor": {"", "device", "installation", "numpy", "resources"},
    "engine": {
        *{"cut_tables", "device", "handles", "interpolation", "packing", "search"},
        *{"numpy", "pyopencl"},
    },
    "filters": {"", "arrays", "gradients", "handle_files", "numpy", "vtkmodules"},
    "fitting": {"grid", "numpy"},
    "gradients": {"interpolation", "numpy"},
    "grid": {"numpy"},
    "guesses": {"numpy"},
    "handle_files": {"numpy"},
    "handles": {"numpy"},
    "installation": {"resources"},
    "interpolation": {"numpy"},
    "image_files": {"arrays", "nrrd", "numpy", "vtkmodules"},
    "io": {"filters", "handle_files", "image_files", "vtkmodules"},
    "nrrd": {"numpy"},
    "packing": {"handles", "numpy"},
    "paraview_gui": {
        *{"filters", "handle_files", "paraview_undo"},
        *{"numpy", "paraview", "vtkmodules"},
    },
    "paraview_scene": {"paraview"},
    "paraview_undo": {"paraview"},
    "reference": {"guesses", "handles", "interpolation", "numpy"},
    "regions": {"handles", "numpy"},
    "resources": set(),
    "search": {"guesses", "numpy", "packing"},
}


def imports(text, package="vtk_mls"):
    """Modules of the package ("" for itself), and outside packages, that `text` imports."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{a.name}" for a in node.names]
        else:
            continue
        for name in names:
            first, _, rest = name.partition(".")
            inner = rest.split(".")[0]
            if first != package:
                found.add(first)
            elif (PACKAGE / f"{inner}.py").exists() or (PACKAGE / inner).is_dir():
                found.add(inner)
            else:  # a public name
                found.add("")
    return found - set(sys.stdlib_module_names) - {"__future__"}


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda p: p.stem)
def test_only_the_agreed_imports(path):
    module = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    extra = imports(path.read_text()) - ALLOWED[module] - {module}
    assert not extra, f"{path.name} must not import {', '.join(sorted(extra))}"


def test_the_test_sees_a_forbidden_import():
    assert imports("from vtk_mls.engine import Engine\nimport os, vtk") == {"engine", "vtk"}
