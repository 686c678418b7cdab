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

`make bench` measured these times, in milliseconds. [Speed](speed.md) says what they mean. Rows
of one table were measured in turns and can be compared. Rows of different machines cannot.

- Rows have 15 control points and alpha 2 (version 0.1: alpha 1) unless their name says otherwise.
- **Within 0.02**: a `MapTolerance` of 0.02 voxel. **Paper's frame**: `CutFrame` is `"deformed"`.
  **All turned**: all control points turn as one body, so no cut opens. **TPS^-1**: the inverse of
  a thin-plate spline. **As fine as the mouse allows**: fewer nodes, so that a live map follows the
  mouse.
- Columns: the smallest of several times, the median, and for drags the 99th percentile. Then the
  smallest time and the **processor** time of all threads, as multiples of the row in bold.
- The paper's times are those of its Table 1, on a GeForce 8800 Ultra and a CPU of 2 GHz.
- **Kernels** are timed alone. A simulator (Oclgrind) counts their **operations** on floats for
  each point in the compiled code. Additions, multiplications, divisions and roots count as one,
  and fused multiply-adds as two. Comparisons, selections and integers do not count. With a
  half-plane the count is too high for a fine grid, because searches start farther away on the
  grid of the simulator. Between nodes it is too high for vectors: cells share rows of nodes there,
  but not in the one lane of the simulator.
- The **bytes** of a point are those of each array that is read or written, once. In a cache they
  may be faster than the memory.
- Operations and bytes stand next to the peaks of the device: fused multiply-adds, and copies in
  memory.
- **Where the time of an update goes**, with a tolerance: nodes, their check, the interpolation
  between them, and points that are computed **exactly**. The rest is Python and, in a filter, VTK.
  The program waits for each kernel here, which takes a little longer. **Its array filled** is the
  time in which the device fills an array of the size of the output.
- The data that an update moves for each voxel are counted where buffers are made. The memory
  **beside** input and output is the largest that the system reports.
- An **exponent** e means that a value grows as size^e, fitted to all sizes of a table. It is 1
  for proportional growth, and less where part of the work does not depend on the size.

To add a machine: `make bench LARGE=1`, copy `build/bench.json` to `tests/benchmarks/results/`,
and `make pages`. The benchmark uses the first GPU, or else the fastest driver for the CPU, or
the device in `VTK_MLS_DEVICE` (`VTK_MLS_DEVICE=cpu make bench LARGE=1`).
"""


def text():
    return "\n".join([HEAD, *(_chapter(path) for path in sorted(RESULTS.glob("*.json")))])


def _chapter(path):
    run = json.loads(path.read_text(encoding="utf-8"))
    lines = [f"## {run['processor']}\n"]
    lines += [f"- {what}: {run[what]}" for what in ("device", "system", "versions")]
    for table in run["tables"]:
        title = table["title"]
        lines += ["", f"### {title[0].upper()}{title[1:]}", "", *_table(table)]
    return "\n".join(lines) + "\n"


def _table(table):
    """Lines of Markdown."""
    heads, *rows = cells(table)
    yield f"| {' | '.join(heads)} |"
    yield "|---" * len(heads) + "|"
    for name, *figures in rows:
        name = f"**{name}**" if name == table.get("base") else name
        yield f"| {' | '.join([name, *figures])} |"


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
