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
    "announcements": set(),
    "arguments": {"cuts", "grid", "numpy", "reals"},
    "arrays": {"grid", "numpy", "vtkmodules"},
    "caches": set(),
    "cli": {"", "commands", "demo", "doctor", "resources", "supervision"},
    "commands": {
        *{"", "arrays", "filters", "handle_files", "installation", "io", "landmarks"},
        *{"mesh_files", "numpy", "series", "supervision", "vtkmodules"},
    },
    "cut_tables": {"cuts", "numpy"},
    "cuts": {"numpy", "reals"},
    "deformation": {
        *{"arguments", "cuts", "dispatch", "fitting", "gradients", "grid", "handles"},
        *{"interpolation", "numpy", "reals", "regions"},
    },
    "demo": {"", "demo_volumes", "dispatch", "filters", "numpy", "vtkmodules"},
    "demo_cut": {"demo_scene", "numpy", "vtkmodules"},
    "demo_mesh": {"demo_picture", "demo_scene", "numpy", "tetgen", "vtkmodules"},
    "demo_picture": {"numpy", "vtkmodules"},
    "demo_scene": {"", "demo_picture", "demo_volumes", "filters", "numpy", "vtkmodules"},
    "demo_volumes": set(),
    "device": {"announcements", "caches", "drivers", "numpy", "pyopencl", "resources"},
    "dispatch": {"announcements", "device", "drivers", "engine", "proof", "reference"},
    "doctor": {
        *{"", "device", "dispatch", "drivers", "installation", "numpy", "proof", "resources"},
    },
    "drivers": {"intel_runtime"},
    "elastix_points": {"landmarks", "numpy"},
    "engine": {
        *{"cut_tables", "device", "handles", "interpolation", "packing", "search"},
        *{"numpy", "pyopencl"},
    },
    "filters": {
        *{"", "announcements", "arrays", "gradients", "handle_files", "provenance", "reals"},
        *{"numpy", "vtkmodules"},
    },
    "field_files": {"meta_image", "nifti", "nrrd", "numpy", "volumes"},
    "fitting": {"grid", "numpy"},
    "frames": {"numpy"},
    "gradients": {"interpolation", "numpy"},
    "grid": {"numpy", "reals"},
    "guesses": {"numpy"},
    "handle_files": {
        *{"elastix_points", "frames", "landmarks", "markups", "numpy", "point_tables"},
        *{"replacing"},
    },
    "handles": {"numpy"},
    "installation": {"resources"},
    "intel_runtime": {"caches"},
    "interpolation": {"numpy"},
    "image_axes": {"", "arrays", "numpy", "vtkmodules"},
    "image_files": {
        *{"arrays", "meta_image", "nifti", "nrrd", "provenance", "volumes"},
        *{"numpy", "vtkmodules"},
    },
    "io": {
        *{"arguments", "arrays", "field_files", "filters", "handle_files", "image_files"},
        *{"landmarks", "mesh_files", "mesh_frames", "provenance"},
        *{"replacing", "validity", "vtkmodules"},
    },
    "landmarks": {"frames", "numpy"},
    "markups": {"frames", "landmarks", "numpy"},
    "mesh_files": {"image_files", "meshio", "volumes", "vtkmodules"},
    "mesh_frames": {"arrays", "frames", "provenance", "vtkmodules"},
    "meta_image": {"numpy", "volumes"},
    "nifti": {"frames", "numpy", "volumes"},
    "nrrd": {"frames", "numpy", "volumes"},
    "packing": {"handles", "numpy"},
    "paraview_arrows": {"filters", "vtkmodules"},
    "paraview_frames": {"arrays", "io", "numpy"},
    "paraview_gui": {
        *{"filters", "handle_files", "paraview_arrows", "paraview_undo"},
        *{"numpy", "paraview", "vtkmodules"},
    },
    "provenance": {"arrays"},
    "paraview_scene": {"paraview"},
    "paraview_undo": {"paraview"},
    "paraview_xml": set(),
    "point_tables": {"frames", "landmarks", "numpy"},
    "proof": {"announcements", "device", "records", "resources"},
    "records": {"caches"},
    "reals": {"numpy"},
    "reference": {"guesses", "handles", "interpolation", "numpy"},
    "regions": {"handles", "numpy"},
    "replacing": set(),
    "resources": set(),
    "self_test": {"", "device", "engine", "numpy", "proof", "reference"},
    "series": {"io", "mesh_files", "replacing", "supervision", "volumes"},
    "supervision": {"replacing"},
    "volumes": {"numpy"},
    "validity": {"arrays", "numpy", "vtkmodules"},
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
