"""Options of the command that are properties of a filter."""

from __future__ import annotations


def add(parser, which, *, flag="", choices=(), text="", more=""):
    """Add the option of a property.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    which : str or Property
        By its name, if the command begins with what filters begin with.
    flag : str, optional
        What the option is called, if not like the property.
    choices : tuple of str, optional
        Those that the command offers, if not all.
    text : str, optional
        Help, if not that of the property.
    more : str, optional
        What the command adds to it.
    """
    each = _properties()[which] if isinstance(which, str) else which
    settings = {"dest": each.option, "default": each.default, **_settings(each)}
    if choices:
        settings["choices"] = choices
    settings["help"] = _help(each, text, more)
    parser.add_argument(flag or f"--{each.option.replace('_', '-')}", **settings)


def apply(options, algorithm):
    """Set the properties of a filter that are options."""
    for each in algorithm.PROPERTIES:
        if hasattr(options, each.option):
            each.assign(algorithm, getattr(options, each.option))


def default(name):
    """The default of a property as an option has it."""
    return _text(value(name))


def value(name):
    """The default of a property."""
    return _properties()[name].default


def _properties():
    """Those of the filters that commands run, by their names."""
    from vtk_mls.filters import property_tables

    tables = (*property_tables.DEFORM, *property_tables.DISPLACEMENT_FIELD)
    return {each.name: each for each in tables}


def _settings(each):
    """What argparse has to know of a kind of property."""
    from vtk_mls.filters import properties

    if isinstance(each, properties.Flag):
        return {"action": "store_true"}
    if isinstance(each, properties.Items):
        return {"action": "append", "metavar": "NAME", "default": []}
    if isinstance(each, properties.Choice):
        return {"choices": each.choices}
    if isinstance(each, properties.ArrayName):
        return {"metavar": "NAME"}
    return {"type": type(each.default), "metavar": each.option.upper()}


def _text(found):
    return ",".join(map(str, found)) if isinstance(found, tuple) else f"{found}"


def _help(each, text, more):
    """A help text as argparse wants it: in one sentence, with the default."""
    text = " ".join((text or each.help).split()).removesuffix(".")
    parts = [part[0].lower() + part[1:] for part in text.split(". ")]
    parts += [more] * bool(more)
    if each.default not in ("", ()) and each.default is not False:
        parts.append(f"default: {_text(each.default)}")
    return "; ".join(parts).replace("%", "%%")
