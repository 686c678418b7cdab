"""The page of the benchmark is that of its results; an update needs little memory."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "benchmarks"


def benchmark(name, monkeypatch):
    """A module of the benchmarks."""
    monkeypatch.setattr(sys, "path", [str(FOLDER), *sys.path])
    return importlib.import_module(name)


def test_the_page_is_that_of_the_results(monkeypatch):
    page = benchmark("page", monkeypatch)
    assert page.PAGE.read_text(encoding="utf-8") == page.text(), "docs/benchmarks.md: make pages"


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="it tells of memory")
@pytest.mark.parametrize(("tolerance", "most"), [(0, 4), (0.02, 14)])
def test_an_update_needs_no_memory_the_size_of_the_volume(tolerance, most, monkeypatch):
    used = benchmark("alone", monkeypatch).memory(256, tolerance)
    assert used["input"] == used["output"] == 32  # two arrays of one byte
    assert used["beside"] < most  # in MB: an array more would have 16
