"""Each word of docs/glossary.md has one meaning: what was said otherwise is said no more.

Names in Python and in the kernels are split at underscores and capitals, docstrings and comments
into words. A word that has given way to another must not be among them.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from fnmatch import fnmatch
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
GLOSSARY = PROJECT / "docs" / "glossary.md"
SOURCES = sorted(
    path
    for folder, pattern in (
        ("vtk_mls", "**/*.py"),
        ("opencl", "*.cl"),
        ("opencl", "*.h"),
        ("paraview_plugin", "*.py"),
    )
    for path in (PROJECT / folder).glob(pattern)
)


def names_of_python(text):
    """Identifiers."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return [token.string for token in tokens if token.type == tokenize.NAME]


def texts_of_python(text):
    """Docstrings and comments."""
    tree = ast.parse(text)
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
    found = [ast.get_docstring(node) or "" for node in ast.walk(tree) if isinstance(node, kinds)]
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return found + [token.string for token in tokens if token.type == tokenize.COMMENT]


def names_of_kernels(text):
    return re.findall(r"[A-Za-z_]\w*", re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S))


def texts_of_kernels(text):
    return re.findall(r"//[^\n]*|/\*.*?\*/", text, flags=re.S)


def words(text):
    """Words of an identifier or a text, in small letters."""
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", text)]


# Words that have given way to others: in names anywhere, and those marked also in texts.
GIVEN_WAY = {
    "drift": "mean displacement",
    "fitting": "fitted grid, fit",
    "opening": "void distance",
    "openings": "void distances",
    "place": "point, position, path",
    "places": "points, positions, paths",
    "turn": "rotation; what is covariant is resampled as such",
    "turned": "rotated, mirrored; covariant",
    "way": "displacement, step, segment",
    "ways": "displacements, steps, segments",
    "handle": "control point, but for what a mouse grabs",
    "handles": "control points, but for what a mouse grabs",
    "lattice": "grid, image geometry; a lattice is of control points",
    "lattices": "grids; a lattice is of control points",
}
IN_TEXTS = {"drift", "handle", "handles", "lattice", "lattices", "openings"}

# Where a word is right, by files.
MOUSE = "what a mouse grabs"
LAYOUT = "control points laid out regularly"
PUBLIC = "a public name of an option, a file or a property"
RIGHT = {
    "handle": {
        "vtk_mls/paraview/*": MOUSE,
        "vtk_mls/editor/*": MOUSE,
        "vtk_mls/pyvista/plotters.py": MOUSE,
        "vtk_mls/web/*": MOUSE,
        "paraview_plugin/*": MOUSE,
        "vtk_mls/filters/handle_*.py": MOUSE,
        "vtk_mls/filters/control_points.py": "the name of a module",
        "vtk_mls/engine/*": "OpenCL's handle of an object, the system's of a file",
        "vtk_mls/rendering/map_texture.py": "OpenGL's handle of an object",
    },
    "handles": {
        "vtk_mls/paraview/*": MOUSE,
        "vtk_mls/editor/*": MOUSE,
        "vtk_mls/pyvista/plotters.py": MOUSE,
        "vtk_mls/web/*": MOUSE,
        "paraview_plugin/*": MOUSE,
        "vtk_mls/commands/*": PUBLIC,
        "vtk_mls/filters/handle_*.py": MOUSE,
        "vtk_mls/engine/device.py": "OpenCL's handles of objects",
    },
    "lattice": {
        "vtk_mls/paraview/*": LAYOUT,
        "vtk_mls/editor/*": LAYOUT,
        "vtk_mls/pyvista/plotters.py": LAYOUT,
        "vtk_mls/web/*": LAYOUT,
        "paraview_plugin/*": LAYOUT,
        "vtk_mls/filters/*": LAYOUT,
    },
    "lattices": {"vtk_mls/editor/*": LAYOUT},
    "place": {
        "vtk_mls/engine/*": "in place, without a copy",
        "vtk_mls/editor/cut_widget.py": "a method of VTK",
    },
}


def misused(name, text):
    """(word, where it stands) of each word in a source that has given way to another."""
    is_python = name.endswith(".py")
    names = names_of_python(text) if is_python else names_of_kernels(text)
    texts = texts_of_python(text) if is_python else texts_of_kernels(text)
    found = [(word, each) for each in names for word in words(each) if word in GIVEN_WAY]
    found += [(word, each) for each in texts for word in words(each) if word in IN_TEXTS]
    return {
        (word, where)
        for word, where in found
        if not any(fnmatch(name, pattern) for pattern in RIGHT.get(word, ()))
    }


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(PROJECT).as_posix())
def test_no_word_is_used_that_has_given_way(path):
    name = path.relative_to(PROJECT).as_posix()
    found = sorted(misused(name, path.read_text()))
    assert not found, "\n".join(
        f"`{word}` in `{where:.80}`: say {GIVEN_WAY[word]}" for word, where in found
    )


def test_the_test_sees_names_and_texts():
    text = 'def _drift_of(x):\n    """Its handles."""\n    # a lattice\n    return wayward, "way"\n'
    assert {word for word, _ in misused("x.py", text)} == {"drift", "handles", "lattice"}
    assert misused("x.cl", "float way = 1; /* the way */ // drift") == {
        ("way", "way"),
        ("drift", "// drift"),
    }
    assert misused("vtk_mls/paraview/x.py", "handle = 1") == set()


def entries():
    """(words, meaning) of each entry of the glossary."""
    text = GLOSSARY.read_text()
    found = re.findall(r"^(\*\*.*)\n: ((?:.+\n)+)", text, re.MULTILINE)
    return [(re.findall(r"\*\*(.+?)\*\*", head), meaning) for head, meaning in found]


def test_each_word_has_one_entry():
    heads = [word.strip() for names, _ in entries() for name in names for word in name.split(",")]
    assert len(heads) > 50
    assert len(heads) == len(set(heads))
    assert not set(heads) & (GIVEN_WAY.keys() - {"handle", "lattice"})
    for names, meaning in entries():
        assert meaning.count("\n") <= 2, f"{names}: two lines suffice"


def test_each_word_is_used():
    text = " ".join(" ".join(words(path.read_text())) for path in SOURCES)
    for names, _ in entries():
        for word in ", ".join(names).split(", "):
            assert f"{' '.join(words(word))}" in text, f"nothing is called {word}"
