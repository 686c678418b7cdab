"""`vtk-mls deform` and `vtk-mls field` of OME-Zarr: block by block, larger than memory."""

from __future__ import annotations

from functools import partial

from vtk_mls.commands import map_options, property_options
from vtk_mls.commands.running import progress_bar
from vtk_mls.commands.supervision import step
from vtk_mls.files.ome_zarr import SUFFIX, is_ome_zarr, open_image

# Options of `vtk-mls deform` and `vtk-mls field` for data in memory.
_IN_MEMORY = {
    "gradient_array": "--gradient",
    "generate_overlap": "--overlap",
    "generate_cell_quality": "--cell-quality",
    "inverse": "--inverse",
    "jacobian": "--jacobian",
    "dimensions": "--dimensions",
}


def add(parser):
    """Add the option of a cluster to a parser."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of OME-Zarr: the scheduler of a dask.distributed cluster, as tcp://host:8786, whose "
        "workers compute; they see the same folders",
    )


def is_for(options):
    """Whether the output is an OME-Zarr.

    Raises
    ------
    ValueError
        If the input is none, or an option is for clusters only.
    """
    if not options.output.lower().endswith(SUFFIX):
        if options.scheduler:
            raise ValueError(
                f"`--scheduler` is for outputs that end in {SUFFIX}, got `{options.output}`"
            )
        return False
    if not is_ome_zarr(options.input):
        raise ValueError(
            f"`{options.output}` can be made of an OME-Zarr only, got `{options.input}`"
        )
    return True


def deform(options):
    """Deform an OME-Zarr."""
    from vtk_mls.ome_zarr import job

    if options.output_grid != "input":
        raise ValueError(f"`--grid` must be input for OME-Zarr, got {options.output_grid}")
    image = open_image(options.input)
    settings = {
        "interpolation": _methods(options, image),
        "background": options.background,
        "void_values": property_options.value("VoidValues"),
    }
    run = partial(job.deform, options.input, options.output, settings=settings)
    note = _run(options, run)
    size = " x ".join(str(n) for n in image.finest.grid.dimensions)
    parts = f"{size} points, {options.kind}; {_count(len(image.levels), 'resolution')}"
    lead = image.finest.array.shape[: len(image.axes.rstrip("zyx"))]
    names = {"t": "time", "c": "channel"}
    for axis, count in zip(image.axes, lead):
        parts += f", {_count(count, names[axis])}"
    if image.labels:
        parts += f", {_count(len(image.labels), 'label image')}"
    print(f"{options.output}: {parts}{note}")
    return 0


def field(options):
    """Write the displacement field on the grid of an OME-Zarr."""
    from vtk_mls.ome_zarr import job

    image = open_image(options.input)
    note = _run(options, partial(job.write_field, options.input, options.output))
    size = " x ".join(str(n) for n in image.finest.grid.dimensions)
    print(f"{options.output}: {size} backward displacements, {options.kind}{note}")
    return 0


def _run(options, run):
    """Call `run` of a transform with a progress bar; a note for the end of a sentence."""
    from vtk_mls import Chain

    for name, flag in _IN_MEMORY.items():
        if getattr(options, name, None):
            raise ValueError(f"`{flag}` is not for OME-Zarr, which is deformed block by block")
    transform = map_options.deformation(options)
    initial = map_options.initial_transform(options)
    if initial is not None:
        transform = Chain([initial, transform])
    with step("deform", options.input), progress_bar(options) as bar:
        note = run(transform, scheduler=options.scheduler, progress=bar)
    return f"; {note}" if note else ""


def _methods(options, image):
    """The interpolation of each channel."""
    labels, names = options.label_arrays or (), image.channel_names
    if not {*labels} <= {*names}:
        raise ValueError(
            f"`--label` must name channels of `{options.input}`, which are {', '.join(names)}, "
            f"got {', '.join(labels)}"
        )
    return tuple("nearest" if name in labels else options.interpolation for name in names)


def _count(count, noun):
    return f"{count} {noun}{'s' * (count != 1)}"
