"""`make bench` asks what it says it asks, and its page is that of its results."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from vtk_mls.engine.dispatch import engine_for

PROJECT = Path(__file__).resolve().parents[2]


MODULES = (
    *("alone", "bench", "contestants", "operations", "page", "peers", "roofline", "traffic"),
)


@pytest.fixture
def benchmarks(monkeypatch):
    """The modules of the benchmarks, by name."""
    monkeypatch.setattr(sys, "path", [str(PROJECT / "tests/benchmarks"), *sys.path])
    modules = {name: importlib.import_module(name) for name in MODULES}
    # its libraries end a process that has as many others as that of the tests
    modules["peers"].OPTIONAL.pop("ITK displacement field (TPS)")
    yield SimpleNamespace(**modules)
    for name in MODULES:
        del sys.modules[name]


def test_the_page_is_that_of_the_results(benchmarks):
    written = benchmarks.page.PAGE.read_text(encoding="utf-8")
    assert written == benchmarks.page.text(), "docs/benchmarks.md is old: make pages"


MORE_QUESTIONS = [
    *((name, (8,), "rigid") for name in ("points", "meshes", "drags", "own_maps", "updates")),
    ("maps_by_grid", ((8, 16),), "8^3"),
    ("maps_by_alpha", (8,), "rigid, 1"),
    ("maps_of_many", (8, 15), "15"),
    ("maps_with_cuts", (8,), "0 planes"),
    ("maps_by_steps", (8,), "1"),
]


@pytest.mark.matrix
@pytest.mark.parametrize(
    ("question", "sizes", "base"),
    [
        *((name, (8,), "rigid") for name in ("maps", "volumes")),
        *(pytest.param(*row, marks=pytest.mark.matrix) for row in MORE_QUESTIONS),
    ],
)
def test_who_is_asked_answers(question, sizes, base, benchmarks, capsys):
    functions = getattr(benchmarks.contestants, question)(*sizes)
    rows = benchmarks.bench.measure(dict(functions), 0, 1, 1)
    benchmarks.bench.show({"title": "displacement map, 64^3", "base": base, "rows": rows})
    printed = capsys.readouterr().out
    assert all(name in printed for name in rows)
    assert len(rows) > 3
    assert not any(figures["smallest"] <= 0 for figures in rows.values())


def test_growth_has_the_exponents_of_times_and_of_memory(benchmarks):
    """Times that grow as size^0.5, within a tolerance as size^0.25; the memory as size^1."""
    sizes = {f"{n}^3": n**3 for n in (8, 16, 32)}
    times = {name: {"median": size**0.5} for name, size in sizes.items()}
    times |= {f"{name}, within 0.02": {"median": size**0.25} for name, size in sizes.items()}
    memory = {name: {"beside": 2.0 * size} for name, size in sizes.items()}
    tables = [
        {"title": "displacement map by the size of the grid", "rows": times},
        {"title": "memory of an update, in MB", "rows": memory},
        {"title": "displacement map by alpha, 64^3", "rows": {"rigid, 1": {"median": 1}}},
    ]
    (table,) = benchmarks.bench.growth(tables)
    assert {name: row["exponent"] for name, row in table["rows"].items()} == {
        "time by points of the grid": 0.5,
        "time by points of the grid, within 0.02": 0.25,
        "memory beside by points of the grid": 1,
    }
    assert table["rows"]["time by points of the grid"]["to"] == 32**3


def test_tables_may_have_columns_of_their_own(benchmarks):
    rows = {"a": {"ms": 1234.5, "GB/s": 2}, "peak": {"GB/s": 3.14159}}
    table = {"title": "kernels", "rows": rows}
    assert list(benchmarks.bench.cells(table)) == [
        ["", "ms", "GB/s"],
        ["a", "1234", "2"],
        ["peak", "", "3.14"],
    ]
    assert list(benchmarks.page._table(table))[2] == "| a | 1234 | 2 |"


def test_operations_are_those_on_floats(benchmarks):
    told = """Instructions executed for kernel 'other':
              99 - fadd
Instructions executed for kernel 'mine':
              40 - getelementptr
              10 - fadd
               7 - call _Z3fmafff()
               3 - fdiv
               2 - call _Z4sqrtf()
               5 - fcmp
               6 - call fadd_group()
"""
    assert benchmarks.operations._operations(told, "mine") == 10 + 2 * 7 + 3 + 2
    assert benchmarks.operations._operations(told, "none") == 0


@pytest.mark.matrix
def test_kernels_have_shares_of_the_peaks(benchmarks, monkeypatch):
    engine, n = engine_for("cpu"), 32
    names = [question.name for question in benchmarks.operations.questions(n)]
    counts = {name: {"point": 100, "pair": 1} for name in names}
    monkeypatch.setattr(benchmarks.operations, "counted", lambda: counts)
    monkeypatch.setattr(benchmarks.roofline, "_RUNS", 1)
    rows = benchmarks.roofline.table(engine, n)
    assert list(rows) == [*names, "peak"]
    assert all(rows[name]["ms"] > 0 for name in names)
    affine, peak = rows["map, affine"], rows["peak"]
    assert affine["G/s"] == pytest.approx(100 * n**3 / affine["ms"] / 1e6)
    assert affine["% of the peak"] == pytest.approx(100 * affine["G/s"] / peak["G/s"])


@pytest.mark.matrix
def test_devices_with_a_memory_of_their_own_tell_how_arrays_come_there(benchmarks, monkeypatch):
    monkeypatch.setattr(benchmarks.roofline, "_COPIED", 1 << 20)
    speeds = benchmarks.roofline.transfers(engine_for("cpu").device)
    assert list(speeds) == ["copy to the device", "copy from the device"]
    assert all(0.01 < speed < 1e5 for speed in speeds.values())


@pytest.mark.matrix
def test_an_update_passes_its_arrays_once(benchmarks):
    rows = benchmarks.traffic.table(32)
    assert rows["rigid"]["read"] == 4
    assert rows["rigid"]["written"] == 4


@pytest.mark.matrix
def test_a_program_that_starts_tells_how_long_its_steps_take(benchmarks):
    steps = benchmarks.alone._asked(["start"])  # with the usual caches: without, minutes
    assert list(steps) == ["import", "device", "first map", "second map"]
    assert 0 < steps["second map"] < steps["first map"]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="it tells of memory")
@pytest.mark.parametrize(("tolerance", "most"), [(0, 4), (0.02, 14)])
def test_an_update_needs_no_memory_the_size_of_the_volume(tolerance, most, benchmarks):
    used = benchmarks.alone.memory(256, tolerance)
    assert used["input"] == used["output"] == 32  # two arrays of one byte
    assert used["beside"] < most  # in MB: an array more would have 16


def test_drags_count_their_slowest(benchmarks):
    times = iter(range(1000))
    rows = benchmarks.bench.measure({"counts": lambda: next(times)}, 0, 100, 100)
    assert rows["counts"].keys() == {"smallest", "median", "p99", "processor"}
    assert next(times) == 101
