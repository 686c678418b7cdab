"""`vtk-mls deform`: an image or a mesh, deformed."""

from __future__ import annotations

from functools import partial

from vtk_mls.commands import map_options, mesh_remarks, property_options, remarks
from vtk_mls.commands.running import each_said_once, read, update
from vtk_mls.commands.supervision import step

_WITH_ALL_ARRAYS = (".vti", ".vtk")  # of the formats of images


def add(commands):
    """Add the command to its parent's parsers."""
    deform = commands.add_parser(
        "deform",
        help="deform an image or a mesh file",
        description="Deform an image or a mesh file, data of several blocks, or a time series. "
        "World coordinates are LPS (x to the left, y to the back of a patient), whatever the frame "
        "of the file, which is written in its own again. Formats with one array (MetaImage, NIfTI, "
        "NRRD) get the active scalars.",
    )
    deform.add_argument(
        "input",
        help="image: .vti .vtk .mha .mhd .nrrd .nhdr .nii .nii.gz .hdr; "
        "mesh: .vtu .vtp .vts .vtr .vtk .stl .ply .obj; pieces, blocks or time steps of these: "
        ".pvti .pvtu .pvtp .pvts .pvtr .vtm .vtpc .vtkhdf .cgns .ex2 .e .exo .case .xdmf; "
        "of the simulation programs that meshio knows: .msh .inp .bdf .med ...; time series: .pvd "
        ".series, or a pattern in quotes as 'step_*.vtu'",
    )
    deform.add_argument("handles", help=map_options.HANDLES)
    deform.add_argument(
        "output",
        help="image: .vti .vtk .mha .mhd .nrrd .nhdr .nii .nii.gz; mesh: .vtu .vtp .vts .vtk "
        ".vtkhdf .stl .ply; blocks: .vtm .vtpc .vtkhdf; time series: .pvd. Of .vtm, .vtpc and .pvd "
        "the data are in a folder beside them",
    )
    add = partial(property_options.add, deform)
    add("Interpolation")
    add("Background")
    add(
        "LabelArrays",
        flag="--label",
        text="array of labels, whose values are not mixed (may be repeated); those of files that "
        "say that they are labels, such as .seg.nrrd, are not mixed anyway",
    )
    add(
        "OutputGrid",
        flag="--grid",
        choices=("input", "fitted"),
        text="grid of the output: the input's, or one that holds all of the deformed volume",
    )
    add("GradientArray", flag="--gradient")
    add(
        "GenerateOverlap",
        flag="--overlap",
        text="also count the points to which material from both sides of a cut has come, of which "
        "an image shows one; .vti and .vtk get the point array Overlap",
    )
    map_options.add(deform)
    deform.set_defaults(run=run)


def run(options):
    """Run the command."""
    from vtk_mls.commands import series
    from vtk_mls.files.replacing import check_replaceable
    from vtk_mls.filters import MLSDeform

    check_replaceable(options.output)
    steps = read(series.read_steps, options.input)
    is_series = options.output.lower().endswith(series.SUFFIX)
    if len(steps) > 1 and not is_series:
        raise ValueError(
            f"`{options.input}` has {len(steps)} time steps, which only a {series.SUFFIX} file can "
            f"hold, got `{options.output}`"
        )
    return (_deform_all if is_series else _deform_one)(steps, MLSDeform(), options)


def _deform_one(steps, deform, options):
    from vtk_mls import io
    from vtk_mls.files.blocks import blocks

    dataset = read(lambda _: steps[0][1](), options.input)
    is_image = dataset.IsA("vtkImageData")
    if is_image:  # what becomes of a mesh depends on cuts
        io.check_writable(options.output, dataset)
        if options.gradient_array and not options.output.lower().endswith(_WITH_ALL_ARRAYS):
            raise ValueError(
                "`--gradient` adds an array, and only .vti and .vtk hold more than one, "
                f"got `{options.output}`"
            )
    deform.SetInputData(0, dataset)
    map_options.apply(options, deform)
    inverted_cells = mesh_remarks.InvertedCells(deform, dataset)
    update(deform, options)
    inverted, output = inverted_cells.taken(), deform.GetOutput()
    said, are_empty = _said(deform), [remarks.is_empty(deform)]
    with step("write", options.output):
        io.write_dataset(output, options.output)
    if is_image:
        size = " x ".join(str(n) for n in output.GetDimensions())
        summary = f"{size} points, {options.kind}{_opened(output)}"
    else:
        size = f"{output.GetNumberOfPoints()} points, {output.GetNumberOfCells()} cells"
        if not output.IsA("vtkDataSet"):
            count = len(blocks(output))
            size = f"{count} block{'s' * (count != 1)}, {size}"
        summary = f"{size}, {options.kind}{_lost(_failures(output))}"
        summary += mesh_remarks.said_of(inverted) + mesh_remarks.left_out(output, options.output)
    _report(summary + said, are_empty, options)
    return 0


def _deform_all(steps, deform, options):
    """Deform all time steps, each when the one before is written."""
    from vtk_mls.commands import series

    lost, inverted, are_empty, said = 0, 0, [], ""
    series.check_writable(options.output)
    map_options.apply(options, deform)
    with each_said_once(), series.writing(options.output) as write:
        for number, (time, read_step) in enumerate(steps):
            dataset = read(lambda _, read_step=read_step: read_step(), options.input)
            deform.SetInputData(0, dataset)
            inverted_cells = mesh_remarks.InvertedCells(deform, dataset)
            update(deform, options, number, len(steps))
            inverted += inverted_cells.taken()
            lost += _failures(deform.GetOutput())
            are_empty.append(remarks.is_empty(deform))
            if number + 1 == len(steps):  # the map is the same for all
                said = _said(deform)
            with step("write", options.output):
                write(time, deform.GetOutput())
    summary = f"{len(steps)} time steps, {options.kind}{_lost(lost)}"
    summary += mesh_remarks.said_of(inverted) + said
    _report(summary, are_empty, options)
    return 0


def _said(deform):
    """What may not have been meant, for the end of a sentence."""
    return "".join(
        say(deform) for say in (remarks.folds_of_images, remarks.whereabouts, remarks.remark)
    )


def _report(summary, are_empty, options):
    """Print what has become of the data."""
    print(f"{options.output}: {summary}")
    emptiness = remarks.emptiness(are_empty, options)
    if emptiness:
        remarks.warn(options.output, emptiness)


def _opened(image):
    """How much of an image cuts have left void, and made to overlap if that was asked for."""
    from vtk_mls.vtk import arrays

    counts = {}
    void = image.GetPointData().GetArray("Void")
    if void is not None:
        counts["void"] = int(arrays.to_numpy(void).astype(bool).sum())
    overlap = image.GetFieldData().GetArray("OverlappingPoints")
    if overlap is not None:
        counts["overlap"] = int(overlap.GetValue(0))
    return "".join(f"; {word}: {count}" for word, count in counts.items())


def _failures(output):
    """Number of points of meshes that had no place to go to."""
    from vtk_mls.files.blocks import blocks

    counts = [block.GetFieldData().GetArray("FailedInverses") for block in blocks(output)]
    return sum(int(count.GetValue(0)) for count in counts if count is not None)


def _lost(count):
    return f"; {count} points lost" * (count > 0)
