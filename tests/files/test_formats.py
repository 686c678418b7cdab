"""The table of formats is whole, and its page in the documentation is what it says."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from vtk_mls.files import formats

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_is_that_of_the_table():
    """`python docs/formats_page.py` makes it."""
    specification = importlib.util.spec_from_file_location("page", DOCS / "formats_page.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    assert (DOCS / "formats.md").read_text() == module.page()


@pytest.mark.parametrize("line", formats.TABLE, ids=lambda line: line.endings)
def test_every_line_has_its_functions(line):
    assert line.reads or line.writes
    assert not line.reads or callable(line.read)
    assert not line.writes or callable(line.write)


@pytest.mark.parametrize("role", ["reads", "writes"])
def test_no_two_lines_claim_a_file_for_the_same(role):
    claims = [
        (ending, word)
        for line in formats.TABLE
        for ending in line.endings.split()
        for word in getattr(line, role)
    ]
    assert len(claims) == len(set(claims))


def test_files_are_found_by_their_longest_ending():
    path = Path("folder.vti/Head.SEG.NRRD")
    line = formats.choose(path, "read", reads=(formats.IMAGE,))
    assert (line.name, line.ending(path)) == ("NRRD", ".seg.nrrd")
    assert formats.find(path, reads=(formats.MESH,)) is None
    assert formats.extensions(formats.MEDICAL) == "mha mhd nrrd nhdr seg.nrrd nii nii.gz"


def test_errors_name_what_could_be_read_or_is_missing(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"cannot read a surface from `x\.png`: .* \.stl, \.vtp"):
        formats.choose(Path("x.png"), "read a surface from", reads=(formats.SURFACE,))
    with pytest.raises(ValueError, match=r"`x\.off` needs the package meshio: pip install meshio"):
        formats.choose(Path("x.off"), "read a mesh from", reads=(formats.MESH,))
