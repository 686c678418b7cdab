"""What is written from the tables of properties is what their programs write today."""

import importlib
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"
OLD = "is old: python docs/properties_page.py"


def program(name, monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    return importlib.import_module(name)


def test_the_page_is_up_to_date(monkeypatch):
    properties_page = program("properties_page", monkeypatch)
    written = properties_page.PAGE.read_text(encoding="utf-8")
    assert written == properties_page.page(), f"docs/properties.md {OLD}"


def test_the_types_are_up_to_date(monkeypatch):
    filter_stubs = program("filter_stubs", monkeypatch)
    written = filter_stubs.STUBS.read_text(encoding="utf-8")
    assert written == filter_stubs.stubs(), f"vtk_mls/filters/__init__.pyi {OLD}"
