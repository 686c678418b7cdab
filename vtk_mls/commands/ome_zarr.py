"""`vtk-mls deform` and `vtk-mls field` of OME-Zarr: block by block, larger than memory."""

from functools import partial

from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.base.progress import SILENT
from vtk_mls.base.sampling import AUTOMATIC
from vtk_mls.blocks import image_job as job
from vtk_mls.blocks.image_blocks import channel_backgrounds
from vtk_mls.commands import property_options, remarks
from vtk_mls.commands.running import files_named, kind_used, progress_bar, set_up
from vtk_mls.commands.supervision import step
from vtk_mls.files.ome_zarr import SUFFIX, is_ome_zarr, open_image
from vtk_mls.filters import pipeline
from vtk_mls.filters.updating import update
from vtk_mls.queries.arrival import coarse
from vtk_mls.vtk.arrays import ImageGeometry

_MAX_SAMPLES = 256  # points along an axis of the grid on which a filter runs


def add(parser):
    """Add the option of a cluster to a parser."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of OME-Zarr: the scheduler of a dask.distributed cluster, as tcp://host:8786, whose "
        "workers compute; they see the same folders",
    )


def is_for(options):
    """Whether the output is an OME-Zarr; ValueError if the input or the options do not fit."""
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
    property_options.check_kinds(options, property_options.OME_ZARR)
    return True


def deform(options, algorithm):
    """Deform an OME-Zarr as a filter says."""
    image = _apply(options, algorithm)
    settings = {
        "interpolation": _methods(options, image),
        "background": _backgrounds(options, algorithm, image),
        "void_values": algorithm.GetVoidValues(),
    }
    notes = remarks.notes(algorithm)
    remarks.warn_of_emptiness([remarks.is_empty(algorithm)], options)  # before long work
    note = _run(options, algorithm, partial(job.deform, settings=settings))
    size = " x ".join(str(n) for n in image.finest.grid.dimensions)
    parts = f"{size} points, {kind_used(algorithm)}; {_count(len(image.levels), 'resolution')}"
    lead = image.finest.array.shape[: len(image.axes.rstrip("zyx"))]
    names = {"t": "time", "c": "channel"}
    for axis, count in zip(image.axes, lead):
        parts += f", {_count(count, names[axis])}"
    if image.labels:
        parts += f", {_count(len(image.labels), 'label image')}"
    if algorithm.GetAutomaticBackground():
        used = channel_backgrounds(image, settings["background"])
        parts += remarks.background([("the image", used)])
    print(f"{options.output}: {parts}{note}{notes}")
    return 0


def field(options, algorithm):
    """Write the displacement field of a filter on the grid of an OME-Zarr."""
    image = _apply(options, algorithm)
    notes = remarks.field_notes(algorithm, is_whole=False)
    note = _run(options, algorithm, job.write_field)
    size = " x ".join(str(n) for n in image.finest.grid.dimensions)
    print(f"{options.output}: {size} backward displacements, {kind_used(algorithm)}{note}{notes}")
    if algorithm.updated_deformation().cuts:
        remarks.warn(options.output, "the void of cuts is not counted, and cannot be marked")
    return 0


def _apply(options, algorithm):
    """The Image of the input; a filter is set up and run on a cell of its grid, without values.

    So options have the errors and warnings that they have with other files. The output has the
    whole grid, for remarks, and automatic steps are those that it needs; a large grid has fewer
    points there.
    """
    image = open_image(options.input)
    geometry = ImageGeometry.of_grid(coarse(image.finest.grid, _MAX_SAMPLES))
    algorithm.SetInputData(0, geometry.apply_to(vtkImageData()))
    set_up(algorithm, options)
    if hasattr(algorithm, "ClearLabelArrays"):
        algorithm.ClearLabelArrays()  # they are channels here
    algorithm.UpdateInformation()
    pipeline.request_extent(algorithm.GetOutputInformation(0), pipeline.first_cell(geometry))
    with step("deform", options.input), files_named(options):
        update(algorithm)
        algorithm.updated_deformation()._prepare(geometry.grid, SILENT)
    algorithm.GetOutput().Initialize()
    geometry.apply_to(algorithm.GetOutput())
    return image


def _run(options, algorithm, run):
    """Run a job with a progress bar; a note for the end of a sentence."""
    transform = algorithm.updated_deformation()
    with step("deform", options.input), progress_bar(options) as bar:
        note = run(
            *(options.input, options.output, transform), scheduler=options.scheduler, progress=bar
        )
    return f"; {note}" if note else ""


def _methods(options, image):
    labels, names = options.label_arrays or (), image.channel_names
    if not {*labels} <= {*names}:
        raise ValueError(
            f"`--label` must name channels of `{options.input}`, which are {', '.join(names)}, "
            f"got {', '.join(labels)}"
        )
    return tuple("nearest" if name in labels else options.interpolation for name in names)


def _backgrounds(options, algorithm, image):
    """The background, or one for each channel if some are labels."""
    if not algorithm.GetAutomaticBackground():
        return algorithm.GetBackground()
    labels = options.label_arrays or ()
    return tuple(0.0 if name in labels else AUTOMATIC for name in image.channel_names)


def _count(count, noun):
    return f"{count} {noun}{'s' * (count != 1)}"
