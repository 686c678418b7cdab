"""`vtk-mls deform`: an image or a mesh, deformed."""

from contextlib import nullcontext
from functools import cache, partial

from vtk_mls import io
from vtk_mls.base.time_steps import step_at
from vtk_mls.commands import map_options, ome_zarr, property_options, remarks, running, series
from vtk_mls.commands.running import distinct_warnings, read, read_image, update
from vtk_mls.commands.supervision import step
from vtk_mls.files.block_files import blocks
from vtk_mls.files.paths import check_apart, check_replaceable
from vtk_mls.filters import MLSDeform
from vtk_mls.filters.image_resampling import backgrounds_of
from vtk_mls.vtk.objects import configured

_MULTI_ARRAY_FORMATS = (".vti", ".vtk", ".pvd")


def add(deform):
    deform.description = (
        "Deform an image or a mesh file, data of several blocks, or a time series. "
        "World coordinates are LPS (x to the left, y to the back of a patient), whatever the frame "
        "of the file; the output has the frame of the input. Formats with one array (MetaImage, "
        "NIfTI, NRRD) get the active scalars."
    )
    deform.add_argument(
        "input",
        help="image: .vti .vtk .mha .mhd .nrrd .nhdr .nii .nii.gz .hdr .tif, also in time; "
        ".ome.zarr; a folder of DICOM slices, or one of them; "
        "mesh: .vtu .vtp .vts .vtr .vtk .stl .ply .obj; pieces, blocks or time steps of these: "
        ".pvti .pvtu .pvtp .pvts .pvtr .vtm .vtpc .vtkhdf .cgns .ex2 .e .exo .case .xdmf; "
        "of the simulation programs that meshio knows: .msh .inp .bdf .med ...; time series: .pvd "
        ".series, or a pattern in quotes as 'step_*.vtu'",
    )
    deform.add_argument("handles", help=map_options.HANDLES)
    deform.add_argument(
        "output",
        help="image: .vti .vtk .mha .mhd .nrrd .nhdr .nii .nii.gz, or .ome.zarr of "
        "one, block by block: an interrupted output is resumed; mesh: .vtu .vtp .vts .vtk "
        ".vtkhdf .stl .ply; blocks: .vtm .vtpc .vtkhdf; time series: .pvd, and for images .mha "
        ".mhd .nrrd .nhdr .nii .nii.gz. .vtm, .vtpc and .pvd files have their data in a folder of "
        "the same name",
    )
    add = partial(property_options.add, deform)
    add("Interpolation")
    add(
        "Background",
        default="auto",
        more="auto: the median of the eight corners of the input, 0 for labels; a series has the "
        "value of its first time step",
    )
    add(
        "LabelArrays",
        flag="--label",
        text="array of labels, whose values are not interpolated (may be repeated); labels are "
        "recognized in files that declare them, such as .seg.nrrd",
    )
    add(
        "OutputGrid",
        flag="--grid",
        choices=("input", "fitted"),
        text="grid of the output: as of the input, or one that holds the whole deformed volume",
    )
    add(
        "Reference",
        text="image whose grid the output of an image has, with its directions, as by -r of "
        "antsApplyTransforms, instead of --grid",
    )
    add("GradientArray", flag="--gradient")
    add(
        "GenerateOverlap",
        flag="--overlap",
        text="also count the points that material from both sides of a cut reaches; an image shows "
        "one side; .vti and .vtk get the point array Overlap",
    )
    add("GenerateCellQuality", flag="--cell-quality")
    map_options.add(deform)
    ome_zarr.add(deform)


def run(options):
    check_apart(options.output, options.input, options.handles)
    if ome_zarr.is_for(options):
        return ome_zarr.deform(options, MLSDeform())
    check_replaceable(options.output)
    steps = read(series.read_steps, options.input)
    handle_times = running.handle_times(options)
    if len(steps) == 1 and handle_times:  # still data
        read_data = cache(steps[0][1])
        steps = [(time, read_data) for time in handle_times]
    deform = configured(MLSDeform(), Reference=_reference(options))
    is_series = len(steps) > 1 or handle_times or options.output.lower().endswith(series.SUFFIX)
    if is_series and not series.can_hold(options.output):
        source = options.handles if handle_times else options.input
        raise ValueError(
            f"`{source}` has {len(steps)} time steps, which only these files can hold: "
            f"{series.suffixes()}; got `{options.output}`"
        )
    if is_series:
        series.check_writable(options.output)
        _check_gradient(options)
    _deform(steps, handle_times, is_series, deform, options)
    return 0


def _reference(options):
    """The image that gives the grid of the output, or None."""
    if options.reference is None:
        return None
    if options.output_grid != "input":
        raise ValueError(
            f"`--reference` is the grid of the output; leave `--grid {options.output_grid}` out"
        )
    return read_image("--reference", options.reference)


def _deform(steps, handle_times, is_series, deform, options):
    """Deform and write one time step after the other, or the only one.

    A time step takes the handles of one of their times, which `step_at` chooses.
    """
    failures, are_empty, notes = 0, [], {}
    inverted_cells = remarks.InvertedCells(deform)
    handles = handle_times and running.control_points_in_time(options, handle_times)
    running.set_up(deform, options, handles[0] if handles else None)
    writer = nullcontext(lambda output: io.write_dataset(output, options.output))
    if is_series:
        writer = series.writing(options.output, [time for time, _ in steps])
    with distinct_warnings(), writer as write:
        for index, (time, read_step) in enumerate(steps):
            dataset = read(lambda _, read_step=read_step: read_step(), options.input)
            property_options.check_kinds(options, *property_options.kinds_of(dataset))
            is_image = dataset.IsA("vtkImageData")
            if is_image and not is_series:  # whether a mesh can be written depends on cuts
                io.check_writable(options.output, dataset)
                _check_gradient(options)
            if handles:
                deform.SetInputData(1, handles[step_at(handle_times, time)][0])
            deform.SetInputData(0, dataset)
            if index == 0 and is_image and is_series:
                deform.series_backgrounds = backgrounds_of(dataset)
            inverted_cells.prepare(dataset)
            update(deform, options, index, len(steps))
            inverted_cells.take()
            output = deform.GetOutput()
            failures += _failures(output)
            are_empty.append(remarks.is_empty(deform))
            if handles or index + 1 == len(steps):  # else the map is the same for all
                note = remarks.notes(deform)
                notes.setdefault(note, f" at time {time:g}" if handles and note else "")
            with step("write", options.output):
                write(output)
    size = f"{len(steps)} time steps" if is_series else _size(output)
    summary = f"{size}, {running.kind_used(deform)}"
    summary += f"; {failures} points lost" * (failures > 0)
    summary += f", handles at {len(handles)} times" * bool(handles) + inverted_cells.note()
    if not is_series:
        summary += _opened(output) if is_image else remarks.dropped_arrays(output, options.output)
    summary += remarks.background(deform.used_backgrounds)
    summary += "".join(f"{note}{where}" for note, where in notes.items())
    print(f"{options.output}: {summary}")
    remarks.warn_of_emptiness(are_empty, options)


def _check_gradient(options):
    if options.gradient_array and not options.output.lower().endswith(_MULTI_ARRAY_FORMATS):
        raise ValueError(
            "`--gradient` adds an array, and only .vti, .vtk and .pvd hold more than one, "
            f"got `{options.output}`"
        )


def _size(output):
    if output.IsA("vtkImageData"):
        return f"{' x '.join(str(n) for n in output.GetDimensions())} points"
    size = f"{output.GetNumberOfPoints()} points, {output.GetNumberOfCells()} cells"
    count = len(blocks(output))
    return size if output.IsA("vtkDataSet") else f"{count} block{'s' * (count != 1)}, {size}"


def _opened(image):
    """Counts of void points, and of overlapping points if the filter counted them."""
    void, overlap = remarks.void(image), image.GetFieldData().GetArray("OverlappingPoints")
    return void if overlap is None else f"{void}; overlap: {int(overlap.GetValue(0))}"


def _failures(output):
    """Number of points of meshes without a forward image."""
    counts = [block.GetFieldData().GetArray("FailedInverses") for block in blocks(output)]
    return sum(int(count.GetValue(0)) for count in counts if count is not None)
