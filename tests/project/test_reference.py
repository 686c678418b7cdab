"""The reference has what the package calls public, and nothing else."""

from __future__ import annotations

import re
from pathlib import Path
from pkgutil import resolve_name

import pytest

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


def objects():
    """What the page has."""
    pytest.importorskip("pyvista")
    return {name: resolve_name(name) for name in listed(PAGE.read_text(encoding="utf-8"))}


@pytest.mark.parametrize("module", PUBLIC)
def test_what_is_public_is_in_the_reference(module):
    there = {id(value) for value in objects().values()}
    public = resolve_name(module)
    missing = [name for name in public.__all__ if id(getattr(public, name)) not in there]
    assert not missing, f"docs/reference/api.md lacks {missing} of {module}"
