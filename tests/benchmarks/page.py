"""Write docs/benchmarks.md: what `make bench` has measured, a chapter for each machine.

python tests/benchmarks/page.py      # from tests/benchmarks/results/*.json
"""

from __future__ import annotations

import json
from pathlib import Path

from bench import cells

PROJECT = Path(__file__).resolve().parents[2]
RESULTS = Path(__file__).parent / "results"
PAGE = PROJECT / "docs/benchmarks.md"
HEAD = """# Benchmarks

What `make bench` has measured, in milliseconds, each table in one run of a kind of machine: the
smallest of several times and the median, of drags the 99th percentile, too; then the smallest,
and the **processor** time of all threads, as multiples of those of the row in bold. Figures of
one table were taken in turns and can be compared; those of different machines cannot.
[Speed](speed.md) says what they mean. The paper's figures are those of its Table 1: a GeForce
8800 Ultra, and a CPU of 2 GHz.

Tables of kernels say how long each takes alone, and its **operations** on floats for a point, as a
simulator (Oclgrind) has counted them in the compiled code: additions, multiplications, divisions
and roots are one, fused multiply-adds two, comparisons, selections and integers none. With a
half-plane that is more than on a fine grid, as searches begin farther off on that of the simulator.
The **bytes** of a point are those of each array that is read or written, once: in a cache, they may
be faster than the memory. Both stand beside the peaks that other kernels have reached on the same
device: fused multiply-adds, and copies in memory. What an update moves for a voxel is counted where
buffers are made; its memory **beside** input and output is the largest that the system has told.
An **exponent** e says that a figure grows as size^e, fitted to all sizes of a table: 1 is in
proportion, and less where a part of the work does not depend on the size.

To add a machine: `make bench LARGE=1`, copy `build/bench.json` to `tests/benchmarks/results/`, and
`make pages`. It measures the first GPU, else the fastest driver for the CPU, or what
`VTK_MLS_DEVICE` names (`VTK_MLS_DEVICE=cpu make bench LARGE=1`).
"""


def text():
    """The page."""
    return "\n".join([HEAD, *(_chapter(path) for path in sorted(RESULTS.glob("*.json")))])


def _chapter(path):
    run = json.loads(path.read_text(encoding="utf-8"))
    lines = [f"## {run['processor']}\n"]
    lines += [f"- {what}: {run[what]}" for what in ("device", "system", "versions")]
    for table in run["tables"]:
        lines += ["", f"### {_capital(table['title'])}", "", *_table(table)]
    return "\n".join(lines) + "\n"


def _table(table):
    """Lines of Markdown."""
    heads, *rows = cells(table)
    yield f"| {' | '.join(heads)} |"
    yield "|---" * len(heads) + "|"
    for name, *figures in rows:
        name = f"**{name}**" if name == table.get("base") else name
        yield f"| {' | '.join([name, *figures])} |"


def _capital(title):
    return title[0].upper() + title[1:]


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
