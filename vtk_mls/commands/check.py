"""`vtk-mls check`: how well pairs of landmarks agree, and which settings suit them."""

import json
from contextlib import contextmanager

from vtk_mls.base.errors import InputError
from vtk_mls.commands import map_options, property_options
from vtk_mls.commands.running import landmarks, progress_bar
from vtk_mls.commands.supervision import step
from vtk_mls.files.landmarks import paired
from vtk_mls.files.paths import check_replaceable, replacing
from vtk_mls.landmarks import report
from vtk_mls.landmarks.text import aligned, heading, page, pair_rows, setting_rows, worst_first

_MAX_ROWS = 20  # in the terminal, beside outliers


def add(check):
    check.description = (
        "Predict each pair of landmarks from all others, by maps of several kinds. "
        "Shows the error of each pair, outliers, pairs whose labels look swapped, and the settings "
        "for `vtk-mls deform` that predict best."
    )
    add = check.add_argument
    add("handles", metavar="pairs", help=map_options.HANDLES)
    map_options.add_files(check)
    add("--json", metavar="FILE", help="write the whole report as JSON")
    add("--html", metavar="FILE", help="write the report as a page")
    property_options.add(check, "Device")
    add("--progress", action="store_true", help="show a progress bar even without a terminal")


def run(options):
    outputs = [path for path in (options.json, options.html) if path is not None]
    for path in outputs:
        check_replaceable(path)
    pairs = _pairs(options)
    names = [label or str(i + 1) for i, label in enumerate(pairs.labels)]
    with step("check", options.handles), _files_named(options), progress_bar(options) as bar:
        settings = {"weights": pairs.weights, "device": options.device or None, "progress": bar}
        result = report(pairs.rest, pairs.deformed, names, **settings)
    print("\n".join(_lines(result)))
    content = json.dumps(result.as_dict(), indent=1, ensure_ascii=False) + "\n"
    for path, text in ((options.json, content), (options.html, page(result))):
        if path is not None:
            with step("write", path), replacing(path) as new:
                new.write_text(text, encoding="utf-8")
    return 0


@contextmanager
def _files_named(options):
    """In errors arguments have the names of their files."""
    rest, deformed = options.handles, options.deformed or options.handles
    both = f"`{rest}`" if rest == deformed else f"`{rest}` and `{deformed}`"
    try:
        yield
    except InputError as error:
        names = {"rest": f"p of `{rest}`", "deformed": f"q of `{deformed}`"}
        raise error.renamed({**names, ("rest", "deformed"): both}) from error


def _lines(report):
    rows = worst_first(report)
    count = max(_MAX_ROWS, int(report.outlier.sum()))
    lines = [*aligned(pair_rows(report, rows[:count]))]
    if count < len(rows):
        lines.append(f"... and {len(rows) - count} more; --json and --html have all")
    return [*lines, "", *aligned(setting_rows(report)), "", *heading(report)]


def _pairs(options):
    rest, deformed, _ = landmarks(options)
    if deformed is None and rest.partners is None:
        raise ValueError(
            f"`{options.handles}` has {len(rest.positions)} positions, and not where they go; say "
            "it in columns qx,qy,qz or by --deformed"
        )
    return paired(rest, deformed, pair_by=options.pair_by)
