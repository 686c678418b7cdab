"""`vtk-mls field`: the displacement field of a deformation, for other programs."""

from __future__ import annotations

from vtk_mls.commands import map_options, property_options, remarks
from vtk_mls.commands.running import read, update
from vtk_mls.commands.supervision import step


def add(commands):
    """Add the command to its parent's parsers."""
    field = commands.add_parser(
        "field",
        help="write the displacement field of a deformation, a transform for other programs",
        description="Write the displacement field of a deformation on the grid of an image, as "
        "SimpleITK, ANTs (antsApplyTransforms -t) and 3D Slicer take it as a transform: resampling "
        "an image with it deforms it as `vtk-mls deform` does. To move points, for which programs "
        "want the other direction of the map, add --inverse.",
    )
    field.add_argument(
        "input",
        help="image, which gives the grid, or mesh, which gives its bounds: as of `vtk-mls deform`",
    )
    field.add_argument("handles", help=map_options.HANDLES)
    field.add_argument(
        "output", help="transform: .nii.gz .nii .nrrd .nhdr .mha .mhd; or for VTK: .vti .vtk"
    )
    add = field.add_argument
    property_options.add(
        field,
        "Inverse",
        text="write where the material goes, which moves points, not where it came from",
    )
    add(
        "--jacobian",
        action="store_true",
        help="write the determinant of the map's Jacobian, one number for each point, instead: "
        "below 0 it is folded",
    )
    add(
        "--dimensions",
        metavar="NX,NY,NZ",
        help="numbers of points over the bounds of a mesh; default: "
        + property_options.default("SampleDimensions"),
    )
    map_options.add(field)
    field.set_defaults(run=run)


def run(options):
    """Run the command."""
    from vtk_mls import io
    from vtk_mls.filters import MLSDisplacementField
    from vtk_mls.vtk.arrays import ImageGeometry

    field = MLSDisplacementField()
    dataset = read(io.read_dataset, options.input)
    if options.jacobian:
        io.check_writable(options.output, field.GetOutput())
    else:
        io.check_field_writable(options.output)
    field.SetInputData(0, dataset if dataset.IsA("vtkDataSet") else _corners(dataset))
    if options.dimensions is not None:
        field.SetSampleDimensions(_dimensions(options, dataset))
    map_options.apply(options, field)
    field.SetGenerateJacobianDeterminant(options.jacobian)
    update(field, options)
    output = field.GetOutput()
    if options.jacobian:
        output.GetPointData().SetActiveScalars("JacobianDeterminant")
    said = remarks.remark(field, is_field=True)
    if not (options.jacobian or options.inverse):  # which count folds themselves
        grid = ImageGeometry.of_image(output).grid
        said = remarks.folds(field.updated_deformation(), grid) + said
    with step("write", options.output):
        (io.write_dataset if options.jacobian else io.write_field)(output, options.output)
    print(f"{options.output}: {_summary(output, options)}{said}")
    for sentence in _remarks(output, options):
        remarks.warn(options.output, sentence)
    return 0


def _dimensions(options, dataset):
    """Numbers of points (nx, ny, nz) over a mesh."""
    if dataset.IsA("vtkImageData"):
        raise ValueError(
            f"`--dimensions` is for meshes: `{options.input}` is an image, and its grid is taken"
        )
    try:
        dimensions = [int(part) for part in options.dimensions.split(",")]
    except ValueError:
        dimensions = []
    if len(dimensions) != 3 or min(dimensions) < 1:
        raise ValueError(
            "`--dimensions` must be three positive integers with commas, "
            f"got `{options.dimensions:.60}`"
        )
    return dimensions


def _corners(blocks):
    """Two points with the bounds of composite data."""
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    bounds, points, corners = [0.0] * 6, vtkPoints(), vtkPolyData()
    blocks.GetBounds(bounds)
    points.SetDataTypeToDouble()
    points.InsertNextPoint(bounds[::2])
    points.InsertNextPoint(bounds[1::2])
    corners.SetPoints(points)
    return corners


def _summary(output, options):
    size = " x ".join(str(n) for n in output.GetDimensions())
    direction = "forward" if options.inverse else "backward"
    void = f"; void: {_number_of(output, 'Void')}" if output.GetPointData().HasArray("Void") else ""
    if not options.jacobian:
        return f"{size} {direction} displacements, {options.kind}{void}"
    folded = output.GetFieldData().GetArray("FoldedVoxels").GetValue(0)
    return f"{size} {direction} determinants, {options.kind}; {folded} of them not above 0{void}"


def _remarks(output, options):
    """Sentences about what the file cannot tell."""
    count, is_whole = output.GetNumberOfPoints(), options.output.lower().endswith((".vti", ".vtk"))
    lost = _number_of(output, "NoInverse")
    if lost:
        value = "is 0" if options.jacobian else "leads to the nearest place that was found"
        yield (
            f"{lost} of {count} points have no forward image, for the map folds or a cut was "
            f"pushed over them; what is written there {value}"
        )
    void = _number_of(output, "Void")
    if void and not is_whole:
        yield (
            f"{void} of {count} points are void, which this format cannot tell: what is written "
            "there is of the material behind the cut; .vti has the array Void"
        )


def _number_of(output, name):
    """How many points of an image an indicator holds for."""
    from vtk_mls.vtk import arrays

    found = output.GetPointData().GetArray(name)
    return 0 if found is None else int(arrays.to_numpy(found).astype(bool).sum())
