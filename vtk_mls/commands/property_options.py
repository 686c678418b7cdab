"""Options of the commands that are properties of a filter, some for some kinds of data only."""

from vtk_mls.files.block_files import blocks
from vtk_mls.filters import properties, property_tables
from vtk_mls.filters.properties import Planes, TransformFile, Value, Values, Vector

IMAGES, MESHES, OME_ZARR = "images", "meshes", "OME-Zarr"
_ONE = {IMAGES: "an image", MESHES: "a mesh", OME_ZARR: "an OME-Zarr, written block by block"}
_ONLY = {  # option and kinds of data, by attribute of the options
    "interpolation": ("--interpolation", (IMAGES, OME_ZARR)),
    "background": ("--background", (IMAGES, OME_ZARR)),
    "label_arrays": ("--label", (IMAGES, OME_ZARR)),
    "output_grid": ("--grid", (IMAGES,)),
    "reference": ("--reference", (IMAGES,)),
    "gradient_array": ("--gradient", (IMAGES,)),
    "generate_overlap": ("--overlap", (IMAGES,)),
    "generate_cell_quality": ("--cell-quality", (MESHES,)),
    "inverse": ("--inverse", (IMAGES, MESHES)),
    "jacobian": ("--jacobian", (IMAGES, MESHES)),
    "sample_dimensions": ("--dimensions", (MESHES,)),
    "spacing_factor": ("--spacing-factor", (IMAGES, MESHES)),
}


def add(parser, item, *, flag="", choices=(), text="", more="", default=None):
    """Add the option of a property, an `item` by its name or itself, to a parser.

    `flag`, `choices`, `text` (the help) and `default` are those of the command; by default they are
    those of the property. `more` is added to the help.
    """
    tables = (*property_tables.DEFORM, *property_tables.DISPLACEMENT_FIELD)
    prop = {prop.name: prop for prop in tables}[item] if isinstance(item, str) else item
    default = prop.default if default is None else default
    settings = {"dest": prop.option, "default": default, **_settings(prop)}
    if choices:
        settings["choices"] = choices
    settings["help"] = _help(prop, text, more, default)
    parser.add_argument(flag or f"--{prop.option.replace('_', '-')}", **settings)


def apply(options, algorithm):
    """Set the properties of a filter from the options, except for those made of texts."""
    for prop in algorithm.PROPERTIES:
        if hasattr(options, prop.option) and not _is_text(prop):
            prop.assign(algorithm, getattr(options, prop.option))


def numbers(flag, text, count):
    """`count` numbers from the text of an option."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise ValueError(f"`{flag}` must be {count} numbers with commas, got `{text:.60}`")
    return values


def check_kinds(options, *kinds):
    """Raise ValueError for an option that has no effect on data of these kinds."""
    for name, (flag, allowed) in _ONLY.items():
        is_given = getattr(options, name, None) != options.parser.get_default(name)
        if is_given and kinds and not set(kinds) & set(allowed):
            raise ValueError(
                f"`{flag}` is for {' and '.join(allowed)}: `{options.input}` is "
                f"{_ONE[kinds[0]]}; leave it out"
            )


def kinds_of(dataset):
    """The kinds of a vtkDataObject and its blocks."""
    return [IMAGES if block.IsA("vtkImageData") else MESHES for block in blocks(dataset)]


def _is_text(prop):
    """Whether the command itself makes the value from the text of the option."""
    return isinstance(prop, (Planes, TransformFile, Value, Values, Vector))


def _settings(prop):
    if isinstance(prop, properties.Flag):
        return {"action": "store_true"}
    if isinstance(prop, properties.Items):
        return {"action": "append", "metavar": "NAME", "default": []}
    if isinstance(prop, properties.Choice):
        return {"choices": prop.choices}
    if isinstance(prop, properties.ArrayName):
        return {"metavar": "NAME"}
    if isinstance(prop, properties.Planes):
        return {"action": "append", "metavar": ",".join(prop.columns).upper(), "default": []}
    if isinstance(prop, properties.Vector):
        return {"metavar": ",".join(prop.labels).upper(), "default": None}
    if isinstance(prop, (properties.TransformFile, properties.Value)):
        return {"metavar": "FILE"}
    if isinstance(prop, properties.Number) and prop.spellings:
        return {"type": prop.parsed, "metavar": "|".join(["N", *prop.spellings])}
    return {"type": type(prop.default), "metavar": prop.option.upper()}


def _help(prop, text, more, default):
    """The help of an option for argparse: one sentence with the default."""
    text = " ".join((text or prop.help).split()).removesuffix(".")
    parts = [part[0].lower() + part[1:] for part in text.split(". ")]
    parts += [more] * bool(more)
    is_stated = isinstance(prop, properties.Dimensions) or not _is_text(prop)
    if default not in ("", ()) and default is not False and is_stated:
        text = ",".join(map(str, default)) if isinstance(default, tuple) else default
        parts.append(f"default: {text}")
    return "; ".join(parts).replace("%", "%%")
