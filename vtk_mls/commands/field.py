"""`vtk-mls field`: the displacement field of a deformation, for other programs."""

import math
from contextlib import suppress

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersSources import vtkOutlineSource

from vtk_mls import Grid, io
from vtk_mls.commands import map_options, ome_zarr, property_options, remarks
from vtk_mls.commands.running import kind_used, read, set_up, update
from vtk_mls.commands.supervision import step
from vtk_mls.files import metadata
from vtk_mls.files.paths import check_apart
from vtk_mls.filters import MLSDisplacementField
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import output_of


def add(field):
    field.description = (
        "Write the displacement field of a deformation on the grid of an image, as "
        "SimpleITK, ANTs (antsApplyTransforms -t) and 3D Slicer read a transform: resampling an "
        "image with it deforms the image as `vtk-mls deform` does. To move points, which needs the "
        "other direction of the map, add --inverse. ITK's own files (.h5 .hdf5 .tfm .txt) get the "
        "best affine transform and the rest of the field, a composite."
    )
    field.add_argument(
        "input",
        help="image, which gives the grid, or mesh, which gives its bounds: as of `vtk-mls deform`",
    )
    field.add_argument("handles", help=map_options.HANDLES)
    field.add_argument(
        "output",
        help="transform: .nii.gz .nii .nrrd .nhdr .mha .mhd; with SimpleITK: .h5 .hdf5 .tfm .txt; "
        "for VTK: .vti .vtk; of an OME-Zarr: .ome.zarr, block by block",
    )
    add = field.add_argument
    property_options.add(
        field,
        "Inverse",
        text="write displacements that move points: to where the material goes, not from where it "
        "comes",
    )
    add(
        "--jacobian",
        action="store_true",
        help="write the determinant of the Jacobian of the map instead, one number for each point: "
        "the map folds below 0",
    )
    add(
        "--field-convention",
        choices=("itk", "ants"),
        default="itk",
        help="vectors of NIfTI: in RAS with the intent code 1006, which SimpleITK and 3D Slicer "
        "read; or in LPS with 1007, which ANTs and nitransforms read, too; default: itk",
    )
    text = "numbers of points over the bounds of a mesh"
    property_options.add(field, "SampleDimensions", flag="--dimensions", text=text)
    add(
        "--spacing-factor",
        metavar="FACTOR",
        help="multiply the spacing of the field: 0.5 has half of it; auto has the largest, down to "
        "an eighth, with which the field does not fold where it is interpolated linearly",
    )
    map_options.add(field)
    ome_zarr.add(field)


def run(options):
    check_apart(options.output, options.input, options.handles)
    field = MLSDisplacementField()
    _check_convention(options)
    if ome_zarr.is_for(options):
        return ome_zarr.field(options, field)
    dataset = read(io.read_dataset, options.input)
    kinds = property_options.kinds_of(dataset)
    kinds += [property_options.IMAGES] * (property_options.MESHES in kinds)
    property_options.check_kinds(options, *kinds)
    if options.jacobian:
        io.check_writable(options.output, field.GetOutput())
    else:
        io.check_field_writable(options.output)
    field.SetInputData(0, dataset if dataset.IsA("vtkDataSet") else _outline(dataset))
    if options.sample_dimensions is not None:
        dimensions = property_options.numbers("--dimensions", options.sample_dimensions, 3)
        field.SetSampleDimensions(dimensions)
    set_up(field, options)
    field.SetGenerateJacobianDeterminant(options.jacobian)
    update(field, options)
    proof = None if options.spacing_factor is None else _space(field, options)
    output = field.GetOutput()
    if options.jacobian:
        output.GetPointData().SetActiveScalars("JacobianDeterminant")
    notes = remarks.field_notes(field, proof=proof)
    with step("write", options.output):
        if options.jacobian:
            io.write_dataset(output, options.output)
        else:
            io.write_field(output, options.output, options.field_convention)
    print(f"{options.output}: {_summary(output, options, field)}{notes}")
    for sentence in _remarks(output, options):
        remarks.warn(options.output, sentence)
    return 0


def _check_convention(options):
    """Raise ValueError if the convention of NIfTI is to be another, of what has none."""
    is_nifti = options.output.lower().endswith((".nii", ".nii.gz")) and not options.jacobian
    if options.field_convention != options.parser.get_default("field_convention") and not is_nifti:
        raise ValueError(
            f"`--field-convention {options.field_convention}` is for displacements in .nii and "
            f".nii.gz, got `{options.output}`{' --jacobian' * options.jacobian}; leave it out"
        )


def _space(field, options):
    """Multiply the spacing of the output by `--spacing-factor`; its Certificate, if known."""
    grid = ImageGeometry.of_image(field.GetOutput()).grid
    factor, proof = _spacing_factor(field, grid, options)
    if factor == 1:
        return proof
    size = (np.array(grid.dimensions) - 1) / factor
    finer = Grid(np.floor(size + 1e-6) + 1, grid.origin, factor * grid.spacing, grid.direction)
    field.SetInputData(0, ImageGeometry.of_grid(finer).apply_to(vtkImageData()))
    update(field, options)
    return None


def _spacing_factor(field, grid, options):
    """The number that `--spacing-factor` gives or finds, and the Certificate that it needed."""
    given = options.spacing_factor
    if given == "auto" and not (options.inverse or options.jacobian or min(grid.dimensions) == 1):
        proof = remarks.certificate(field, grid)
        finer = grid.spacing if proof.spacing is None else proof.spacing
        return float(finer[0] / grid.spacing[0]), proof
    with suppress(ValueError):
        if 0 < float(given) < math.inf:
            return float(given), None
    raise ValueError(
        "`--spacing-factor` must be a positive number, or auto for backward displacements in "
        f"space, got `{given:.60}`"
    )


def _outline(blocks):
    """The corners of the bounds of composite data."""
    bounds, precision = [0.0] * 6, vtkOutlineSource.DOUBLE_PRECISION
    blocks.GetBounds(bounds)
    return output_of(vtkOutlineSource(), Bounds=bounds, OutputPointsPrecision=precision)


def _summary(output, options, field):
    size = " x ".join(str(n) for n in output.GetDimensions())
    direction = "forward" if options.inverse else "backward"
    kind, void = kind_used(field), remarks.void(output)
    if not options.jacobian:
        return f"{size} {direction} displacements, {kind}{void}"
    folded = output.GetFieldData().GetArray("FoldedVoxels").GetValue(0)
    return f"{size} {direction} determinants, {kind}; {folded} of them not above 0{void}"


def _remarks(output, options):
    """Warnings about points whose state the file cannot hold."""
    count, is_whole = output.GetNumberOfPoints(), options.output.lower().endswith((".vti", ".vtk"))
    failures = remarks.number_of(output, "NoInverse")
    if failures:
        value = "is 0" if options.jacobian else "leads to the nearest place that was found"
        yield (
            f"{failures} of {count} points have no forward image, for the map folds or a cut was "
            f"pushed over them; the value there {value}"
        )
    unit = "".join(metadata.load(output, metadata.LENGTH_UNIT))
    if unit and options.output.lower().endswith((".nii", ".nii.gz")) and not options.jacobian:
        yield f"it is in millimeters, for images in NIfTI, while the input is in {unit}"
    void = remarks.number_of(output, "Void")
    if void and not is_whole:
        yield (
            f"{void} of {count} points are void, which this format cannot mark: the displacement "
            "there is that of the material behind the cut; .vti has the array Void"
        )
