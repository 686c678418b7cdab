"""`vtk-mls deform`: an image or a mesh, deformed."""

from __future__ import annotations

from vtk_mls.commands import map_options
from vtk_mls.commands.running import read, update
from vtk_mls.supervision import step


def add(commands):
    """Add the command to its parent's parsers."""
    from vtk_mls import INTERPOLATIONS

    deform = commands.add_parser(
        "deform",
        help="deform an image or a mesh file",
        description="Deform an image or a mesh file. World coordinates are LPS (x to the left, y "
        "to the back of a patient), whatever the frame of the file, which is written in its own "
        "again. Formats with one array (MetaImage, NIfTI, NRRD) get the active scalars.",
    )
    deform.add_argument(
        "input",
        help="image: .vti .vtk .mha .mhd .nrrd .nhdr .nii .nii.gz .hdr; "
        "mesh: .vtu .vtp .vts .vtr .vtk .stl .ply .obj",
    )
    deform.add_argument("handles", help=map_options.HANDLES)
    deform.add_argument(
        "output",
        help="image: .vti .vtk .mha .mhd .nrrd .nhdr .nii .nii.gz; "
        "mesh: .vtu .vtp .vts .vtk .stl .ply",
    )
    add = deform.add_argument
    add("--interpolation", choices=INTERPOLATIONS, default="linear", help="default: %(default)s")
    add("--background", type=float, default=0.0, help="value outside; default: 0")
    add(
        "--label",
        metavar="NAME",
        action="append",
        default=[],
        help="array of labels, whose values are not mixed (may be repeated); those of files that "
        "say that they are labels, such as .seg.nrrd, are not mixed anyway",
    )
    add(
        "--grid",
        choices=("input", "fitted"),
        default="input",
        help="grid of the output: the input's, or one that holds all of the deformed volume",
    )
    add(
        "--gradient",
        metavar="NAME",
        default="",
        help="point array whose gradient in the deformed image is wanted, as array Gradient",
    )
    map_options.add(deform)
    deform.set_defaults(run=run)


def run(options):
    """Run the command."""
    from vtk_mls import io
    from vtk_mls.filters import MLSDeform

    deform = MLSDeform()
    dataset = read(io.read_dataset, options.input)
    is_image = dataset.IsA("vtkImageData")
    if is_image:  # what becomes of a mesh depends on cuts
        io.check_writable(options.output, dataset)
    deform.SetInputData(0, dataset)
    map_options.apply(options, deform)
    deform.SetInterpolation(options.interpolation)
    deform.SetBackground(options.background)
    deform.SetOutputGrid(options.grid)
    deform.SetGradientArray(options.gradient)
    for name in options.label:
        deform.AddLabelArray(name)
    update(deform, options)
    output = deform.GetOutput()
    with step("write", options.output):
        io.write_dataset(output, options.output)
    if is_image:
        size = " x ".join(str(n) for n in output.GetDimensions())
        print(f"{options.output}: {size} points, {options.kind}")
    else:
        lost = output.GetFieldData().GetArray("FailedInverses").GetValue(0)
        size = f"{output.GetNumberOfPoints()} points, {output.GetNumberOfCells()} cells"
        print(f"{options.output}: {size}, {options.kind}" + (f"; {lost} points lost" * (lost > 0)))
    return 0
