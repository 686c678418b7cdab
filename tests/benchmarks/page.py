"""Write docs/benchmarks.md: what `make bench` has measured, a chapter for each machine.

python tests/benchmarks/page.py      # from tests/benchmarks/results/*.json
"""

from __future__ import annotations

import json
from pathlib import Path

from bench import paper

PROJECT = Path(__file__).resolve().parents[2]
RESULTS = Path(__file__).parent / "results"
PAGE = PROJECT / "docs/benchmarks.md"
HEAD = """# Benchmarks

What `make bench` has measured, in milliseconds, one run for each kind of machine: the smallest of
several times, the median, and the **processor** time of all threads, as a multiple of that of the
row in bold; of drags the 99th percentile, too. Figures of one table were taken in turns and can be
compared; those of different machines cannot. [Speed](speed.md) says what they mean. The paper's
figures are those of its Table 1: a GeForce 8800 Ultra, and a CPU of 2 GHz.

To add a machine: `make bench LARGE=1`, copy `build/bench.json` to `tests/benchmarks/results/`, and
`make pages`.
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
    rows, base, papers = table["rows"], table["base"], paper(table["title"])
    columns = [each for each in rows[base] if each != "processor"]
    heads = ["", *columns, "processor", *(("the paper's GPU", "its CPU") if papers else ())]
    yield f"| {' | '.join(heads)} |"
    yield "|---" * len(heads) + "|"
    for name, figures in rows.items():
        cells = [f"**{name}**" if name == base else name]
        cells += [_three_digits(figures[each]) for each in columns]
        cells.append(f"{figures['processor'] / rows[base]['processor']:.2f}")
        if papers:
            cells += map(str, papers.get(name, ("", "")))
        yield f"| {' | '.join(cells)} |"


def _capital(title):
    return title[0].upper() + title[1:]


def _three_digits(value):
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
