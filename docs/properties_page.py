"""Writes properties.md, the reference page of the filters' properties, from their tables.

python docs/properties_page.py
"""

from argparse import ArgumentParser
from pathlib import Path

import array_table

from vtk_mls.commands import deform, field
from vtk_mls.filters import property_tables as tables
from vtk_mls.filters.properties import Items, Rows, Value, Values

PAGE = Path(__file__).with_name("properties.md")
HEAD = """# Properties of the filters

`python docs/properties_page.py` makes this page from `vtk_mls/filters/property_tables.py`. In
Python, a property `X` of a filter has the methods `SetX` and `GetX`. Vectors are given as
`SetX(1, 2, 3)` or as one sequence. In ParaView and `pvpython` it is the property `X` of the
proxy. Options are those of `vtk-mls deform` and `vtk-mls field`.
"""
ARRAYS = """\
The input ControlPoints has the point arrays `Displacement` (q - p) and `Weight`. To use another
array for q - p, call
`SetInputArrayToProcess(0, 1, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, name)`. For the weights,
the first argument is 1. In ParaView, set DisplacementArray and WeightArray. Drag and
LatticeDimensions of ParaView's panel are for the mouse only."""
REPORT = """\
The output has two tables. *Pairs* has a row for each pair of landmarks: Name, Rest, Deformed,
Moved, Error (when left out), Outlier, SwappedWith. Its field data are Recommended,
SmallestDeterminant and Summary. *Settings* has a row for each setting that was tried, best
first: Kind, Degree, Order, Alpha, Smoothing, Softening, Median, Options, Recommended. Alpha 0 is
one map for all pairs. Arrays of the input are chosen as above."""
OUTPUTS = """\
The filters write these arrays beside the arrays of their inputs, which they carry along. The
table is made from `docs/array_table.py`; a test compares it with the output of the
filters.
"""
# Of values of `vtk_mls`.
_IN_PARAVIEW = {
    "Cuts": "in ParaView only as the input of this name",
    "Mask": "in ParaView only as the input of this name",
    "Reference": "in ParaView only as the input of this name",
    "Handles": "in ParaView only as cells of ControlPoints",
    "Constraints": "not in ParaView",
}
SECTIONS = (
    ("MLSDeform and MLSDisplacementField", ARRAYS, tables.DEFORMING),
    ("MLSDeform", "In addition to the properties above:", tables.DEFORM),
    ("MLSDisplacementField", "In addition to the properties above:", tables.DISPLACEMENT_FIELD),
    ("MLSControlPoints", "", tables.CONTROL_POINTS),
    ("MLSLandmarkReport", REPORT, tables.LANDMARK_REPORT),
)


def page():
    """The text of the page."""
    parts, options = [HEAD], _options()
    for title, text, table in SECTIONS:
        is_shared = table is tables.DEFORMING or table is tables.CONTROL_POINTS
        own = [prop for prop in table if is_shared or prop not in tables.DEFORMING]
        flags = {} if table is tables.CONTROL_POINTS else options
        parts.append(f"## {title}\n" + f"\n{text}\n" * bool(text))
        parts += [_entry(prop, flags.get(prop.option)) for prop in own]
    return "\n".join([*parts, _arrays()])


def _arrays():
    """The section of what the filters write."""
    lines = ["## Arrays\n", OUTPUTS, "| array | data | of | values | |", "|---|---|---|---|---|"]
    for row in array_table.TABLE:
        about = f"{row.help} {row.when}." if row.when else row.help
        cells = (f"`{row.name}`", row.of, ", ".join(row.writers), row.values, about)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def _entry(each, flag):
    """What the page says of one property."""
    lines = [" ".join(text.split()) for text in (each.help, each.more) if text]
    facts = [each.expected.removesuffix(".")]
    if isinstance(each, Items):
        facts.append(f"`Add{each.singular}`, `Clear{each.name}`, `Get{each.name}`")
    elif isinstance(each, Rows):
        facts.append(f"also `Set{each.singular}(index, {', '.join(each.columns)})`")
    if flag:
        facts.append(f"option `{flag}`")
    facts += _panel(each)
    return f"### {each.name}\n\n{' '.join(lines)}\n\n*{'; '.join(facts)}.*\n"


def _panel(each):
    """What is to be said of the property in ParaView."""
    if isinstance(each, (Value, Values)):
        yield _IN_PARAVIEW[each.name]
    if each.only_for:
        yield f"only for {each.only_for}"
    if each.is_advanced:
        yield "among ParaView's advanced properties"
    if each.shown_when:
        name, *values = each.shown_when
        yield f"shown while {name} is {' or '.join(map(_state, values))}"
    if each.hidden_when:
        name, value = each.hidden_when
        also = f" and {each.shown_with} is not connected" if each.shown_with else ""
        yield f"shown unless {name} is {_state(value)}{also}"


def _state(value):
    return "not connected" if value is None else f'"{value}"'


def _options():
    """Options of the command by the names of what they set."""
    parsers = ArgumentParser(), ArgumentParser()
    for command, parser in zip((deform, field), parsers):
        command.add(parser)
    return {
        action.dest: action.option_strings[0]
        for parser in parsers
        for action in parser._actions
        if action.option_strings
    }


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
