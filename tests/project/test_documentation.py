"""Links of README and the pages of the site exist, their commands parse, their code compiles."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import vtk_mls
from vtk_mls import cli, filters

PROJECT = Path(__file__).resolve().parents[2]
DOCS = PROJECT / "docs"
PAGES = [
    *(PROJECT / name for name in ("README.md", "CONTRIBUTING.md", "opencl/README.md")),
    *sorted(DOCS.glob("*.md")),
    *sorted((DOCS / "reference").glob("*.md")),
]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
COMMANDS = ("vtk-mls", "make", "python", ".ci/run")


def named(path):
    return path.relative_to(PROJECT).as_posix()


pages = pytest.mark.parametrize("page", PAGES, ids=named)


def blocks(text, language):
    """The code in fences of a language."""
    return [code for name, code in FENCE.findall(text) if name == language]


def shell_lines(text):
    """Commands in fences without a language or of `sh`, and in indented blocks."""
    lines = re.findall(r"^ {4}(\S.*)$", FENCE.sub("", text), re.MULTILINE)
    for language in ("", "sh"):
        lines += "\n".join(blocks(text, language)).splitlines()
    return [line for line in lines if line.split(" ")[0] in COMMANDS]


def wrong(line, targets):
    """What is wrong with a command line, or None."""
    program, *words = shlex.split(line, comments=True)
    if program == "make":
        missing = [word for word in words if "=" not in word and word not in targets]
        return f"no target {missing}" if missing else None
    if program == "vtk-mls":
        if "..." in words:  # quoted for its options alone
            return None
        try:
            cli._parser().parse_args(cli._with_values(words))
        except SystemExit as end:
            return None if end.code == 0 else "the command does not take it"
    files = [word for word in words if word.endswith(".py") and "/" in word]
    lost = [word for word in files if not (PROJECT / word).is_file()]
    return f"no file {lost}" if lost else None


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
    assert not {line: what for line, what in told.items() if what}


OBJECTS = {"deform": filters.MLSDeform, "handles": filters.MLSControlPoints}
OBJECTS |= {"d": vtk_mls.Deformation}


def exists(module, name):
    """Whether `from module import name` would work."""
    if hasattr(importlib.import_module(module), name):
        return True
    return importlib.util.find_spec(f"{module}.{name}") is not None


# The recipes of CONTRIBUTING import what they write; test_recipes.py runs them.
@pytest.mark.parametrize("page", [each for each in PAGES if each.stem != "CONTRIBUTING"], ids=named)
def test_python_names_exist(page):
    for code in blocks(page.read_text(encoding="utf-8"), "python"):
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("vtk_mls"):
                missing = [each.name for each in node.names if not exists(node.module, each.name)]
                assert not missing, f"{node.module} has no {missing}"
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                owner = OBJECTS.get(node.value.id)
                assert owner is None or hasattr(owner, node.attr), f"{owner} has no {node.attr}"


def test_a_wrong_command_is_found():
    assert wrong("vtk-mls deform a.vti b.csv c.vti --no-such", ()) == "the command does not take it"
    assert wrong("make nothing", ("docs",)) == "no target ['nothing']"
    assert wrong("python docs/nothing.py", ()) == "no file ['docs/nothing.py']"


# Whole programs, from a file to a file.
COOKED = blocks((DOCS / "python.md").read_text(encoding="utf-8"), "python")[:1]
COOKED += blocks((DOCS / "cookbook.md").read_text(encoding="utf-8"), "python")


@pytest.mark.matrix
@pytest.mark.parametrize("code", COOKED, ids=range(len(COOKED)))
def test_programs_run(code, tmp_path):
    if "jupyter" in code:
        pytest.skip("tests/pyvista executes a notebook")
    sitk = pytest.importorskip("SimpleITK")
    sitk.WriteImage(sitk.GaussianSource(size=[24] * 3), str(tmp_path / "head.nii.gz"))
    (tmp_path / "handles.csv").write_text("px,py,pz,qx,qy,qz\n1,2,3,4,5,6\n9,8,7,9,8,7\n")
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
