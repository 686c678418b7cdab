"""Links of README and the pages of the site exist, their commands parse, their Python runs."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import re
import shlex

import numpy as np
import pytest
from command_fixtures import PROJECT, python
from vtk_fixtures import can_draw

import vtk_mls
from vtk_mls import filters
from vtk_mls.commands import cli
from vtk_mls.files import field_files

DOCS = PROJECT / "docs"
PAGES = [
    *(PROJECT / name for name in ("README.md", "CONTRIBUTING.md", "opencl/README.md")),
    *sorted(DOCS.glob("*.md")),
    *sorted((DOCS / "reference").glob("*.md")),
]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
COMMANDS = ("vtk-mls", "make", "python", "pip", ".ci/run")
_EXTRA_TABLE = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")
_EXTRA_TABLE = _EXTRA_TABLE.partition("[project.optional-dependencies]")[2].partition("\n[")[0]
EXTRAS = set(re.findall(r"^(\w+) = \[", _EXTRA_TABLE, re.MULTILINE))


def named(path):
    return path.relative_to(PROJECT).as_posix()


pages = pytest.mark.parametrize("page", PAGES, ids=named)


def blocks(text, language):
    """The code in fences of a language."""
    return [code for name, code in FENCE.findall(text) if name == language]


def shell_lines(text):
    """Commands in fences without a language or of `sh`, and in indented blocks."""
    prose = FENCE.sub("", text)
    lines = re.findall(r"^ {4}(\S.*)$", prose, re.MULTILINE)
    for language in ("", "sh"):
        lines += "\n".join(blocks(text, language)).splitlines()
    return [command for line in lines for command in commands(line)]


def mentions(text):
    """Commands within a sentence, perhaps without their files."""
    return [
        command
        for line in re.findall(r"`([^`]+)`", FENCE.sub("", text))
        for command in commands(line)
    ]


def commands(line):
    """The commands of ours in a line of a shell, in loops and in $() too."""
    line = re.sub(r"(^|\s)#.*", "", line)
    inner = re.findall(r"\$\(([^)]*)\)", line)
    parts = re.split(r";|&&|\|", re.sub(r"\$\([^)]*\)", "", line)) + inner
    parts = [re.sub(r"^(do|then) ", "", part.strip()) for part in parts]
    return [part for part in parts if " " in part and part.split(" ")[0] in COMMANDS]


def wrong(line, targets):
    """What is wrong with a command line, or None."""
    program, *words = shlex.split(line, comments=True)
    if program == "make":
        missing = [word for word in words if "=" not in word and word not in targets]
        return f"no target {missing}" if missing else None
    if program == "vtk-mls":
        return None if is_taken(words) else "the command does not take it"
    if program == "pip":
        asked = re.findall(r"(?:\.|vtk-mls)\[([\w,]+)\]", line)
        missing = sorted({extra for group in asked for extra in group.split(",")} - EXTRAS)
        return f"no extra {missing}" if missing else None
    files = [word for word in words if word.endswith(".py") and "/" in word]
    lost = [word for word in files if not (PROJECT / word).is_file()]
    return f"no file {lost}" if lost else None


def is_taken(words):
    try:
        cli._parser().parse_args(cli._with_values(words))
    except SystemExit as end:
        return end.code == 0
    return True


@pages
def test_links_lead_somewhere(page):
    text = re.sub(r"`[^`\n]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))
    lost = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        path = target.partition("#")[0]
        if re.match(r"\w+:", target) or not path:
            continue
        gallery = re.fullmatch(r"gallery/(\w+)\.rst", path)
        made = PROJECT / "examples" / f"{gallery[1]}.py" if gallery else page.parent / path
        if not made.exists() and path != "gallery/index.rst":
            lost.append(target)
    assert not lost


@pages
def test_commands_are_taken(page, capsys):
    targets = re.findall(r"^(\w+):", (PROJECT / "Makefile").read_text(), re.MULTILINE)
    text = page.read_text(encoding="utf-8")
    told = {line: wrong(line, targets) for line in shell_lines(text)}
    for line in mentions(text):
        files = ("", " a", " a b", " a b c")
        told[line] = line.startswith("vtk-mls ") and all(wrong(line + file, ()) for file in files)
    assert not {line: what for line, what in told.items() if what}


OBJECTS = {"deform": filters.MLSDeform, "handles": filters.MLSControlPoints}
OBJECTS |= {"d": vtk_mls.Deformation}


def exists(module, name):
    """Whether `from module import name` would work."""
    if hasattr(importlib.import_module(module), name):
        return True
    return importlib.util.find_spec(f"{module}.{name}") is not None


# The recipes of CONTRIBUTING import what they write; test_recipes.py runs them.
@pytest.mark.parametrize(
    "page", [page_path for page_path in PAGES if page_path.stem != "CONTRIBUTING"], ids=named
)
def test_python_names_exist(page):
    for code in blocks(page.read_text(encoding="utf-8"), "python"):
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("vtk_mls"):
                missing = [
                    alias.name for alias in node.names if not exists(node.module, alias.name)
                ]
                assert not missing, f"{node.module} has no {missing}"
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                owner = OBJECTS.get(node.value.id)
                assert owner is None or hasattr(owner, node.attr), f"{owner} has no {node.attr}"


# What a block of Python finds there: the names that the text around it tells of, or those of the
# blocks before it. A page's blocks that are not listed are whole programs.
CONTROL_POINTS = """
import numpy as np
rest = np.array([(0, 0, 0), (20, 0, 0), (0, 20, 0), (0, 0, 20), (20, 20, 20)], float)
deformed = rest + [(2, 0, 0), (0, 0, 0), (0, 0, 0), (0, 1, 0), (0, 0, 0)]
points = np.array([(1.0, 2, 3), (4, 5, 6)])
"""
WAVELET = """
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource
reader = vtkRTAnalyticSource()
reader.SetWholeExtent(0, 20, 0, 20, 0, 20)
reader.Update()
"""
DRAWN = """
import vtkmodules.vtkRenderingOpenGL2, vtkmodules.vtkRenderingVolumeOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow, vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper
from vtk_mls import Deformation
mapper, volume = vtkGPUVolumeRayCastMapper(), vtkVolume()
mapper.SetInputConnection(reader.GetOutputPort())
volume.SetMapper(mapper)
renderer, window = vtkRenderer(), vtkRenderWindow()
window.SetOffScreenRendering(True)
window.AddRenderer(renderer)
renderer.AddViewProp(volume)
deformation = Deformation(rest, deformed)
"""
CUT = """
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtk_mls.filters import MLSControlPoints, MLSDeform
from vtk_mls.vtk.objects import configured
scalpel = configured(vtkPlaneSource(), Origin=(10, 0, 10), Point1=(10, 20, 10), Point2=(10, 0, 20))
handles = configured(MLSControlPoints(), RestPoints=rest, DeformedPoints=deformed)
deform = MLSDeform()
deform.SetInputConnection(0, reader.GetOutputPort())
deform.SetInputConnection(1, handles.GetOutputPort())
reader.GetOutput().GetPointData().GetScalars().SetName("T1")
image = reader.GetOutput()
deform.SetInputData(0, image)
"""
BENT = """
from vtk_mls import io
io.write_dataset(io.read_dataset("head.nii.gz"), "bent.vti")
"""
PYVISTA = """
import pyvista as pv
import vtk_mls.pyvista
pv.OFF_SCREEN = True
"""
MESH = "mesh = pv.examples.load_hexbeam()\nplotter = pv.Plotter()\n"
GIVEN = {
    ("README", 0): CONTROL_POINTS + "point, normal, inward = (10, 0, 10), (1, 0, 0), (0, 0, 1)\n",
    ("README", 1): CONTROL_POINTS + PYVISTA + MESH,
    ("python", 1): WAVELET,
    ("python", 2): CONTROL_POINTS + WAVELET + DRAWN,
    ("python", 3): PYVISTA,
    ("python", 4): CONTROL_POINTS + "volume = np.zeros((256, 256, 256), np.float32)\n",
    ("python", 5): CONTROL_POINTS,
    ("cuts", 0): CONTROL_POINTS + WAVELET + CUT,
    ("paraview_clicks", 0): BENT,
}
BLOCKS = [
    pytest.param(GIVEN.get((page.stem, number), ""), code, id=f"{page.stem}-{number}")
    for page in PAGES
    if page.stem != "CONTRIBUTING"
    for number, code in enumerate(blocks(page.read_text(encoding="utf-8"), "python"))
]


@pytest.mark.matrix
@pytest.mark.parametrize(("given", "code"), BLOCKS)
def test_python_runs(given, code, tmp_path):
    for package in ("pyvista", "SimpleITK"):
        if re.search(rf"^import {package}", given + code, re.MULTILINE):
            pytest.importorskip(package)
    if re.search(r"Plotter\(|vtkRenderWindow", given + code) and not can_draw():
        pytest.skip("VTK cannot draw here")
    write_files(tmp_path)
    arguments = "-c", given + code
    status, _, err = python(*arguments, folder=tmp_path, PYVISTA_OFF_SCREEN="true")
    assert status == 0, err
    assert "ERR|" not in err, err


def write_files(folder):
    """The files that blocks read: an image, control points, and a field."""
    sitk = pytest.importorskip("SimpleITK")
    sitk.WriteImage(sitk.GaussianSource(size=[24] * 3), str(folder / "head.nii.gz"))
    (folder / "handles.csv").write_text("px,py,pz,qx,qy,qz\n1,2,3,4,5,6\n9,8,7,9,8,7\n")
    grid = vtk_mls.Grid((4, 4, 4), (0, 0, 0), (8, 8, 8))
    field_files.write(np.zeros((4, 4, 4, 3), np.float32), grid, folder / "warp.nii.gz")
