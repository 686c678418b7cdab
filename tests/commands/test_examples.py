"""The numpy and VTK examples pass their own checks; that for pvpython runs in test_scripts.py."""

from __future__ import annotations

import ast
import re

import numpy as np
import pytest
from command_fixtures import PROJECT, python
from vtk_fixtures import can_draw

EXAMPLES = sorted(
    path for path in (PROJECT / "examples").glob("*.py") if "paraview" not in path.name
)


# `make docs` runs all of them, for its gallery.
ON_EACH_CHANGE = {"numpy_deform", "vtk_deform"}


def marked(path):
    marks = () if path.stem in ON_EACH_CHANGE else pytest.mark.matrix
    return pytest.param(path, id=path.stem, marks=marks)


@pytest.mark.parametrize("example", [marked(example) for example in EXAMPLES])
def test_example(example, tmp_path):
    if re.search(r"vtkRenderWindow|Plotter\(", example.read_text()) and not can_draw():
        pytest.skip("VTK cannot draw here")
    status, out, err = python(example, folder=tmp_path, PYVISTA_OFF_SCREEN="true")
    assert status == 0, out + err
    assert out.strip()
    assert "ERR|" not in err, err


@pytest.mark.parametrize("name", ["vtk_live", "pyvista_deform"])
def test_a_folder_is_no_picture(name):
    status, _, err = python(PROJECT / "examples" / f"{name}.py", ".")
    assert (status, err) == (1, "the picture must be a .png file, got `.`\n")


def test_a_curve_that_runs_back_is_refused():
    tree = ast.parse((PROJECT / "examples" / "straightened.py").read_text(encoding="utf-8"))
    statements = ast.ImportFrom | ast.FunctionDef
    tree.body = [node for node in tree.body if isinstance(node, statements)]  # without its run
    names = {"np": np}
    exec(compile(tree, "straightened.py", "exec"), names)
    hook = [(0, 0, 0), (0, 0, 9), (2, 0, 9), (2, 0, 6)]
    with pytest.raises(ValueError, match="`centerline` must not run back .* after node 2;"):
        names["straight"](hook)
