"""`make bench` asks what it says it asks, and its page is that of its results."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]


@pytest.fixture
def benchmarks(monkeypatch):
    """The modules of the benchmarks."""
    monkeypatch.setattr(sys, "path", [str(PROJECT / "tests/benchmarks"), *sys.path])
    import bench
    import contestants
    import page

    yield bench, contestants, page
    for name in ("bench", "contestants", "page"):
        del sys.modules[name]


def test_the_page_is_that_of_the_results(benchmarks):
    _, _, page = benchmarks
    written = page.PAGE.read_text(encoding="utf-8")
    assert written == page.text(), "docs/benchmarks.md is old: make pages"


@pytest.mark.long
@pytest.mark.parametrize(
    "question", ["maps", "volumes", "points", "meshes", "maps_with_cuts", "drags", "maps_of_many"]
)
def test_who_is_asked_answers(question, benchmarks, capsys):
    bench, contestants, _ = benchmarks
    sizes = (8, 15) if question == "maps_of_many" else (8,)
    rows = bench.measure(dict(getattr(contestants, question)(*sizes)), 0, 1, 1)
    bases = {"maps_of_many": "15", "maps_with_cuts": "0 planes"}
    table = {"title": "displacement map, 64^3", "base": bases.get(question, "rigid"), "rows": rows}
    bench.show(table)
    printed = capsys.readouterr().out
    assert all(name in printed for name in rows)
    assert len(rows) > 3
    assert not any(figures["smallest"] <= 0 for figures in rows.values())


def test_drags_count_their_slowest(benchmarks):
    bench, _, _ = benchmarks
    times = iter(range(1000))
    rows = bench.measure({"counts": lambda: next(times)}, 0, 100, 100)
    assert rows["counts"].keys() == {"smallest", "median", "p99", "processor"}
    assert next(times) == 101
