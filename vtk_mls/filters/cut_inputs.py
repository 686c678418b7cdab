"""Cuts from properties and from polydata."""

import numpy as np
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkPolyDataConnectivityFilter

from vtk_mls import Surface
from vtk_mls.base.errors import InputError
from vtk_mls.filters.property_tables import CUT_FIELDS, CUT_TYPE
from vtk_mls.model.cuts import BY_NUMBERS
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import connectivity_of, positions_of, triangulated
from vtk_mls.vtk.objects import configured, output_of

_ON_CUT = 1e-6  # distance from a cut of points on it, as a share of the points' extent


def own_values(algorithm):
    """The name of the shape of the cut that properties describe, and the values of its fields."""
    name = CUT_TYPE.checked(algorithm)
    fields = BY_NUMBERS[name].fields if name in BY_NUMBERS else ()
    return name, *(getattr(algorithm, CUT_FIELDS[field.name].attribute) for field in fields)


def own_cuts(name, *values):
    """The cut of `own_values`, as a tuple of none or one."""
    if name not in BY_NUMBERS:
        return ()
    shape = BY_NUMBERS[name]
    try:
        return (shape(*values),)
    except InputError as error:
        raise InputError(error.predicate, argument=CUT_FIELDS[error.argument].name) from error


def surfaces(polydata):
    """The surfaces of a vtkPolyData as cuts, a list of Surface.

    Polygons and triangle strips become triangles; points at the same place are one, and what is
    no triangle then is left out, as lines and vertices are. Parts that do not hang together are
    cuts of their own. Raises ValueError if there is no surface, a point is not finite, or a
    triangle has no area.
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
