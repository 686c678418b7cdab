"""Each word of docs/glossary.md has one meaning: what was said otherwise is said no more.

Names in Python and in the kernels are split at underscores and capitals, and docstrings and comments
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


if __name__ == "__main__":
    import collections
    OLD = "lattice lattices way ways turn turned turns opening openings drift fitting handle handles place places beside sound".split()
    for word in OLD:
        n, t = collections.Counter(), collections.Counter()
        for path in SOURCES:
            text = path.read_text()
            py = path.suffix == ".py"
            for name in (names_of_python if py else names_of_kernels)(text):
                n[path.relative_to(PROJECT)] += word in words(name)
            for x in (texts_of_python if py else texts_of_kernels)(text):
                t[path.relative_to(PROJECT)] += words(x).count(word)
        print(word, "NAMES", {str(k): v for k, v in n.items() if v}, "\n    TEXT", {str(k): v for k, v in t.items() if v})
