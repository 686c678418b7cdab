"""Control points, cuts, masks and faces from properties, polydata and images."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkImageData
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkPolyDataConnectivityFilter

from vtk_mls import BallMask, FixedFace, ImageMask, Plane, SlidingFace, Surface
from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import as_float, short_repr
from vtk_mls.filters.property_tables import CUT_FIELDS, CUT_TYPE
from vtk_mls.model.cuts import BY_NUMBERS
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import connectivity_of, positions_of, triangulated
from vtk_mls.vtk.control_point_polydata import DISPLACEMENT, WEIGHT
from vtk_mls.vtk.objects import configured, output_of

_ON_CUT = 1e-6  # distance from a cut of points on it, as a share of the points' extent


def listed_control_points(algorithm, rest=None, deformed=None, weights=None):
    """p and q (n, 3) float64, world coordinates, and weights (n,) float64 or None, by properties.

    `rest` replaces RestPoints; `deformed` and `weights` are defaults for empty lists.
    ValueError if the lists differ in length, or do not hold numbers.
    """
    if rest is None:
        rest = as_float_rows("RestPoints", algorithm.GetRestPoints(), (3,))

    def listed(name, values, row, default):
        values = as_float_rows(name, values, row)
        if len(values) not in (0, len(rest)):
            raise InputError(
                f"must be none or one for each of the {len(rest)} rest points, got {len(values)}",
                argument=name,
            )
        return values if len(values) else default

    deformed = rest if deformed is None else deformed
    deformed = listed("DeformedPoints", algorithm.GetDeformedPoints(), (3,), deformed)
    return rest, deformed, listed("Weights", algorithm.GetWeights(), (), weights)


def _array_name(algorithm, index, polydata):
    """Name of the array or active attribute selected by SetInputArrayToProcess, or None."""
    info = algorithm.GetInputArrayInformation(index)
    if info.Has(vtkDataObject.FIELD_NAME()):
        return info.Get(vtkDataObject.FIELD_NAME())
    if info.Has(vtkDataObject.FIELD_ATTRIBUTE_TYPE()):
        kind = info.Get(vtkDataObject.FIELD_ATTRIBUTE_TYPE())
        active = polydata.GetPointData().GetAbstractAttribute(kind)
        return active.GetName() if active else None
    return None


def control_point_arrays(algorithm, polydata):
    """Names of the arrays of control points with q - p and, or None, with weights."""
    displacement = _array_name(algorithm, 0, polydata) or DISPLACEMENT
    weight = _array_name(algorithm, 1, polydata) or WEIGHT
    if weight == WEIGHT and not polydata.GetPointData().HasArray(weight):
        weight = None
    return displacement, weight


def as_float_rows(name, values, row):
    """The float64 array of shape (n, *row) of the property `name`."""
    try:
        return as_float(name, values).reshape(len(values), *row)
    except (TypeError, ValueError):
        expected = f"rows of {row[0]} numbers" if row else "numbers"
        raise InputError(f"must be {expected}, got {short_repr(values)}", argument=name) from None


def own_values(algorithm):
    """The name of the shape of the cut that properties describe, and the values of its fields."""
    name = CUT_TYPE.checked(algorithm)
    fields = BY_NUMBERS[name].fields if name in BY_NUMBERS else ()
    return name, *(getattr(algorithm, CUT_FIELDS[field.name].attribute) for field in fields)


def own_cuts(name, *values):
    """The cut of `own_values`, as a tuple of none or one."""
    if name not in BY_NUMBERS:
        return ()
    try:
        return (BY_NUMBERS[name](*values),)
    except InputError as error:
        raise InputError(error.predicate, argument=CUT_FIELDS[error.argument].name) from error


def surfaces(polydata):
    """The surfaces of a vtkPolyData as cuts, a list of Surface.

    Polygons and triangle strips become triangles; points at the same place are one, and what is
    no triangle then is left out, as lines and vertices are. Parts that do not hang together are
    cuts of their own. ValueError if there is no surface, a point is not finite, or an area is 0.
    """
    points = polydata.GetPoints()
    if points is not None and not np.isfinite(arrays.to_numpy(points.GetData())).all():
        raise ValueError("`Cuts` has a point that is not finite")
    triangles = triangulated(polydata)
    clean = output_of(vtkCleanPolyData(), InputData=triangles, ConvertPolysToLines=False)
    if clean.GetNumberOfPolys() == 0:
        raise ValueError(
            "`Cuts` has no surface; it must have polygons or triangle strips, got "
            f"{polydata.GetNumberOfPoints()} points and {polydata.GetNumberOfLines()} lines"
        )
    parts = configured(vtkPolyDataConnectivityFilter(), ColorRegions=True)
    parts.SetExtractionModeToAllRegions()
    result = output_of(parts, InputData=clean)
    triangles = connectivity_of(result.GetPolys())[0].reshape(-1, 3)
    part = arrays.to_numpy(result.GetPointData().GetArray("RegionId"))[triangles[:, 0]]
    cuts = []
    for index in range(part.max() + 1):
        used, rows = np.unique(triangles[part == index], return_inverse=True)
        try:
            cuts.append(Surface(positions_of(result)[used], rows.reshape(-1, 3)))
        except ValueError as error:
            raise ValueError(f"`Cuts` has no usable surface: {error}") from error
    return cuts


def off_cuts(cuts, rest, deformed, cut_frame):
    """Control points (n, 3) on flat cuts moved off them, and which are ignored: (n,) bool.

    With `cut_frame` "rest" they move slightly to the side that they are dragged to. Those that stay
    at rest would hold the cut shut, and are ignored.
    """
    is_ignored, is_still = np.zeros(len(rest), bool), (rest == deformed).all(axis=1)
    for cut in cuts:
        with np.errstate(invalid="ignore", over="ignore"):  # errors are reported later
            rounding = _ON_CUT * np.ptp(rest, axis=0).max(initial=0)
            on_cut = cut.void_distance(rest, rest) <= rounding
            is_ignored |= is_still & on_cut
            if cut_frame == "rest":
                side = np.where(cut.plane.height(deformed) < 0, -1, 1)
                offset = side * rounding - cut.plane.height(rest)
                rest = np.where(on_cut[:, None], rest + offset[:, None] * cut.plane.normal, rest)
    return rest, is_ignored


def one_mask(ball, mask, images=()):
    """The mask of the properties MaskBall and Mask, and of the input Mask; None without."""
    names = ["`MaskBall`"] * bool(np.any(ball)) + ["`Mask`"] * (mask is not None)
    names += ["the input `Mask`"] * len(images)
    if len(names) > 1:
        raise ValueError(
            f"a deformation has one mask, got {' and '.join(names)}; multiply them to one image"
        )
    if images:
        return image_mask(images[0])
    return image_mask(mask) if isinstance(mask, vtkImageData) else mask or ball_mask(ball)


def ball_mask(row, name="`MaskBall`"):
    """The BallMask of five numbers x, y, z, radius, falloff; None for zeros."""
    values = as_float(name.strip("`"), row)
    if values.shape != (5,):
        raise ValueError(
            f"{name} must be five numbers: x, y, z, radius, falloff; got {short_repr(tuple(row))}"
        )
    if not values.any():
        return None
    try:
        return BallMask.of_numbers(values)
    except ValueError as error:
        raise ValueError(f"{name} is no ball: {error}") from error


def image_mask(image, name="`Mask`"):
    """The ImageMask of the scalars of a vtkImageData; errors have the `name`.

    Integers are labels: what is not 0 is inside. Other numbers go from 0 to 1.
    """
    data = image.GetPointData()
    array = data.GetScalars() or (data.GetArray(0) if data.GetNumberOfArrays() == 1 else None)
    if array is None or array.GetNumberOfComponents() != 1:
        components = "none" if array is None else f"{array.GetNumberOfComponents()} in each point"
        raise ValueError(f"{name} must be an image with one number in each point, got {components}")
    grid = arrays.ImageGeometry.of_image(image).grid
    values = arrays.to_numpy(array).reshape(grid.shape)
    if values.dtype.kind in "biu":
        values = values != 0
    elif not ((values >= 0) & (values <= 1)).all():
        raise ValueError(
            f"{name} must have numbers from 0 to 1, got {values.min():g} to {values.max():g}; "
            "divide them by their largest value, or save labels as integers"
        )
    try:
        return ImageMask(values, grid)
    except ValueError as error:
        raise ValueError(f"{name} is no mask: {error}") from error


def faces(fixed, sliding):
    """The faces of the properties FixedPlanes and SlidingPlanes, a list."""
    kinds = ("FixedPlanes", fixed, FixedFace), ("SlidingPlanes", sliding, SlidingFace)
    return [
        face(kind, row, f"`{name}`, row {index},")
        for name, rows, kind in kinds
        for index, row in enumerate(as_float_rows(name, rows, (7,)))
    ]


def face(kind, row, where):
    """A FixedFace or SlidingFace of seven numbers x, y, z, nx, ny, nz, falloff."""
    try:
        return kind(Plane(row[:3], row[3:6]), row[6])
    except ValueError as error:
        raise ValueError(f"{where} is no plane with a fall-off: {error}") from error
