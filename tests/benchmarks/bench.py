"""Measure vtk_mls against other programs, side by side in one run.

Each question is asked of everyone who can answer it, with 15 control points:

- the displacement map of a grid (the paper's Table 1);
- a volume, deformed: one filter from image to image; and again and again, while one is dragged;
- points, moved forward by the inverse of the map that deforms the volume, as many as the grid has;
- a mesh of two million tetrahedra, likewise: one filter from mesh to mesh. What a cut splits is
  kept from run to run, as it is while control points are dragged;
- the same maps by size of the grid, number of control points, cuts and steps, and alpha.

Cuts (of the rigid kind) are in the rest frame, and in the deformed one as the paper has them. Maps
"within 0.02" have that map tolerance.

Everyone runs once to warm up (kernels are built, threads started) and then several times, in
turns; the smallest and the median time are printed, and the smallest processor time of all threads
as a multiple of that of the kind that others are compared with: what else the machine does hardly
changes that. Of drags the 99th percentile counts, too. VTK's filters use its thread pool
(STDThread).

Then follow, without others: how near kernels are to the peaks of the device, how much memory an
update needs, and how a program starts. All of it is left in a file, from which `make pages` writes
docs/benchmarks.md. Ours run on the device that VTK_MLS_DEVICE names.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from importlib.util import find_spec
from itertools import chain
from pathlib import Path

import alone
import contestants
import numpy as np
import peers
import pyopencl
import roofline
from vtkmodules.vtkCommonCore import vtkSMPTools, vtkVersion

import vtk_mls
from vtk_mls.engine.dispatch import engine_for

# Table 1 of the paper, milliseconds on its GPU (GeForce 8800 Ultra) and its CPU (2 GHz).
PAPER = {
    ("64^3", "affine"): (4, 633),
    ("64^3", "rigid"): (8, 1125),
    ("64^3", "similarity"): (8, 1133),
    ("64^3", "polynomial, degree 2"): (102, 9270),
    ("128^3", "affine"): (15, 4868),
    ("128^3", "rigid"): (45, 8779),
    ("128^3", "similarity"): (45, 8976),
    ("128^3", "polynomial, degree 2"): (460, 117180),
    ("256^3", "affine"): (104, 38550),
    ("256^3", "rigid"): (325, 69970),
    ("256^3", "similarity"): (325, 70550),
    ("256^3", "polynomial, degree 2"): (730, 793000),
}
DRAGS = 200  # moves


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--large", action="store_true", help="also 256^3, and 100,000 handles")
    parser.add_argument("--output", type=Path, default="build/bench.json", metavar="FILE")
    arguments = parser.parse_args()
    vtkSMPTools.SetBackend("STDThread")
    run = machine()
    for what, value in run.items():
        print(f"{what:12}{value}")
    for name in peers.absent():
        print(f"Not installed here, so not measured: {name} (pip install 'vtk-mls[bench]')")
    tables = run["tables"] = []
    for table in chain(timings(arguments.large), accounts(arguments.large), growth(tables)):
        tables.append(table)
        show(table)
        # what was measured is there even if the rest is not waited for
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        arguments.output.write_text(json.dumps(run, indent=1) + "\n")


def timings(is_large):
    """Tables of who is quick."""
    for title, base, functions, *limits in questions(is_large):
        yield {"title": title, "base": base, "rows": measure(dict(functions), *limits)}


def questions(is_large):
    """(title, what others are compared with, who answers, and limits of `measure` if special)."""
    for n in (64, 128, 256) if is_large else (64, 128):
        yield f"displacement map, {n}^3", "rigid", contestants.maps(n)
        yield f"deformed volume, {n}^3", "rigid", contestants.volumes(n)
        if n < 256:  # the search takes long where polynomials fold the box
            yield f"points moved forward, {n}^3", "rigid", contestants.points(n)
    if is_large:
        yield "displacement map, 512^3", "rigid", contestants.own_maps(512), 0, 3, 3
    yield "mesh of 2 million tetrahedra (341,991 points)", "rigid", contestants.meshes(55)
    most = 100_000 if is_large else 20_000
    many = contestants.maps_of_many(64, most)
    yield "displacement map by the number of control points, 64^3", "15", many
    yield "displacement map by the number of cuts, 64^3", "0 planes", contestants.maps_with_cuts(64)
    yield "displacement map by the number of steps, 64^3", "1", contestants.maps_by_steps(64)
    sizes = (32, 64, 128, 256, 512) if is_large else (32, 64, 128)
    yield "displacement map by the size of the grid", "64^3", contestants.maps_by_grid(sizes)
    yield "displacement map by alpha, 64^3", "rigid, 1", contestants.maps_by_alpha(64)
    for n in (64, 128):
        yield f"drag of a volume, {n}^3", "rigid", contestants.drags(n), 0, DRAGS, DRAGS
    yield "live map of a drag, 64^3", "rigid", contestants.live_maps(), 0, DRAGS, DRAGS


def accounts(is_large):
    """Tables of what is no contest, with columns of their own."""
    engine = engine_for()
    n = 256 if engine.device.kind == "gpu" else 128  # no launch is to be all start and end
    title = f"kernels of 15 control points, {n}^3, and the peaks of the device"
    yield {"title": title, "rows": roofline.table(engine, n)}
    rows = {
        f"{n}^3{told}": alone.memory(n, tolerance)
        for n in ((64, 128, 256, 512) if is_large else (64, 128, 256))
        for told, tolerance in contestants.TOLERANCES.items()
    }
    if all(rows.values()):
        yield {"title": "memory of an update, labels and a scalar of one byte, in MB", "rows": rows}
    if find_spec("zarr"):
        import large

        title = "OME-Zarr of 2-byte voxels on disk, deformed block by block"
        yield {"title": title, "rows": large.table((1024, 1024, 512))}
    if is_large:
        yield {"title": "start of a program, in milliseconds", "rows": alone.starts()}


def growth(tables):
    """A table of exponents e: figures of the `tables` grow as size^e, in the mean of all sizes."""
    rows = {}
    for what, start, figure in (
        ("time by points of the grid", "displacement map by the size of the grid", "median"),
        ("time by control points", "displacement map by the number of control points", "median"),
        ("time by steps", "displacement map by the number of steps", "median"),
        ("memory beside by points of the grid", "memory of an update", "beside"),
    ):
        for table in (table for table in tables if table["title"].startswith(start)):
            for told in contestants.TOLERANCES:
                measured = {
                    _size(name.removesuffix(told)): figures[figure]
                    for name, figures in table["rows"].items()
                    if name.removesuffix(told).removesuffix("^3").isdigit()
                    and name.endswith(told)
                    and figures[figure] > 0
                }
                if len(measured) > 1:
                    slope = np.polyfit(*np.log([[*measured], [*measured.values()]]), 1)[0]
                    least, most = min(measured), max(measured)
                    rows[what + told] = {"from": least, "to": most, "exponent": round(slope, 3)}
    yield {"title": "growth, as exponents", "rows": rows}


def _size(name):
    """The size that the name of a row has: a number, or that of the points of a grid."""
    return int(name.removesuffix("^3")) ** (3 if name.endswith("^3") else 1)


def machine():
    """Where it runs, as {what: str}."""
    model = platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        told = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        names = [line.partition(":")[2] for line in told.splitlines() if "model name" in line]
        model = names[0].strip() if names else model
    versions = {
        "vtk_mls": vtk_mls.__version__,
        "VTK": vtkVersion.GetVTKVersion(),
        "numpy": np.__version__,
        "pyopencl": pyopencl.VERSION_TEXT,
        "Python": platform.python_version(),
    }
    return {
        "processor": f"{model}, {os.cpu_count()} threads",
        "system": platform.platform(),
        "device": engine_for().NAME,
        "versions": ", ".join(f"{name} {version}" for name, version in versions.items()),
    }


def measure(functions, seconds=2.0, least=5, most=30):
    """Milliseconds of each function of a dict, after one run to warm up.

    They take turns, so that what else the machine does meets them all alike. A function has run
    enough after so many seconds and `least` runs, and after `most` runs in any case. For each the
    dict has the "smallest" and the "median", from a hundred runs on the "p99" (99th percentile),
    and the smallest "processor" time of all threads.
    """
    times, processor = ({name: [] for name in functions} for _ in range(2))
    for function in functions.values():
        function()
    for turn in range(most):
        for name, function in functions.items():
            if turn < least or sum(times[name]) < seconds:
                start, used = time.perf_counter(), time.process_time()
                function()
                times[name].append(time.perf_counter() - start)
                processor[name].append(time.process_time() - used)
    rows = {}
    for name, taken in times.items():
        figures = {"smallest": min(taken), "median": np.median(taken)}
        if len(taken) >= 100:
            figures["p99"] = np.percentile(taken, 99)
        figures["processor"] = min(processor[name])
        rows[name] = {what: round(1000 * value, 2) for what, value in figures.items()}
    return rows


def show(table):
    print(f"\n{table['title']}" + (", milliseconds" if "base" in table else ""))
    heads, *rows = cells(table)
    widths = [
        max(36, *(len(row[0]) + 1 for row in rows)),
        *(max(12, len(h) + 2) for h in heads[1:]),
    ]
    for name, *figures in (heads, *rows):
        aligned = (text.rjust(width) for text, width in zip(figures, widths[1:]))
        print(name.ljust(widths[0]) + "".join(aligned))


def cells(table):
    """Rows of texts: heads, then figures behind a name."""
    rows = table["rows"]
    if "base" not in table:
        heads = list(dict.fromkeys(head for figures in rows.values() for head in figures))
        yield ["", *heads]
        for name, figures in rows.items():
            yield [name, *(_three_digits(figures[h]) if h in figures else "" for h in heads)]
        return
    base, papers = rows[table["base"]], paper(table["title"])
    columns = [column for column in base if column != "processor"]
    heads = ["", *columns, f"x {table['base']}", "processor"]
    yield heads + (["the paper's GPU", "its CPU"] if papers else [])
    for name, figures in rows.items():
        row = [name, *(_three_digits(figures[column]) for column in columns)]
        row += [f"{figures[column] / base[column]:.2f}" for column in ("smallest", "processor")]
        yield row + ([*map(str, papers.get(name, ("", "")))] if papers else [])


def _three_digits(value):
    return f"{value:.0f}" if abs(value) >= 100 else f"{value + 0.0:.3g}"


def paper(title):
    """The paper's figures for a table, as {name: (GPU, CPU)} in milliseconds."""
    question, _, size = title.partition(", ")
    if question != "displacement map":
        return {}
    return {name: times for (n, name), times in PAPER.items() if n == size}


if __name__ == "__main__":
    main()
