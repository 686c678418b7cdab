"""Properties that are derived from the options of deformations and from the fields of cuts."""

from vtk_mls.filters.properties import Choice, Number, Slider, Text, Vector
from vtk_mls.model import cuts, options

WITH_CUTS = {"is_advanced": True, "hidden_when": ("CutType", "none"), "shown_with": "Cuts"}
CUT_SHAPES = tuple(cuts.BY_NUMBERS.values())


def _of_option(option, is_interactive=False):
    """The property of an option; `is_interactive` takes the default of ParaView and the editor."""
    default = option.interactive_default if is_interactive else option.default
    keywords = {
        "more": option.more,
        "is_advanced": option.is_advanced or option.section == "computing",
    }
    if option.section == "cut":
        keywords |= WITH_CUTS
    if option.needs:
        name, *values = option.needs
        keywords["shown_when"] = (options.named(name).property_name, *values)
    about = option.property_name, "" if default is None else default, option.help
    ends = option.slider and option.slider[:2]
    if not ends and option.choices and isinstance(option.default, int):
        ends = min(option.choices), max(option.choices)
    if ends:
        return Slider(*about, low=ends[0], high=ends[1], **keywords)
    if option.choices:
        return Choice(*about, choices=option.choices, **keywords)
    if option.default is None:
        return Text(*about, **keywords)
    return Number(*about, spellings=option.spellings, **keywords)


def of_section(section, is_interactive=False):
    """Properties of the options in a section of panels."""
    return tuple(_of_option(o, is_interactive) for o in options.OPTIONS if o.section == section)


def of_cut_field(field):
    """The property of a field of cut shapes, shown for the shapes that have it."""
    names = [shape.name for shape in CUT_SHAPES if field.name in (f.name for f in shape.fields)]
    shown = {"hidden_when": ("CutType", "none")}
    if len(names) < len(CUT_SHAPES):
        shown = {"shown_when": ("CutType", *names)}
    make = Number if field.kind == "length" else Vector
    name = f"Cut{(field.title or field.name).capitalize()}"
    return make(name, field.default, field.help, unit="world coordinates", **shown)
