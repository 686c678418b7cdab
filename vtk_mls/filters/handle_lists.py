"""Control points by properties: lists of places and weights, and the polydata they make."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray

from vtk_mls import arrays
from vtk_mls.reals import real, shown


class HandleLists:
    """What is asked of an algorithm that has control points of its own, by properties.

    These are RestPoints, DeformedPoints and Weights.
    """

    def _handle_lists(self):
        """The lists as one value that can be compared."""
        return self.GetRestPoints(), self.GetDeformedPoints(), self.GetWeights()

    def _handles(self, rest=None, deformed=None, weights=None):
        """p, q and weights.

        Parameters
        ----------
        rest : (n, 3) float64, optional
            p, if they are not those listed.
        deformed, weights : (n, 3) and (n,) float64, optional
            What counts where the list is empty.

        Returns
        -------
        rest, deformed : (n, 3) float64, world coordinates
        weights : (n,) float64 or None

        Raises
        ------
        ValueError
            If the lists differ in length, or what they hold is not numbers.
        """
        if rest is None:
            rest = numbers_of("RestPoints", self.GetRestPoints(), (3,))
        listed = {
            "DeformedPoints": numbers_of("DeformedPoints", self.GetDeformedPoints(), (3,)),
            "Weights": numbers_of("Weights", self.GetWeights(), ()),
        }
        for name, values in listed.items():
            if len(values) not in (0, len(rest)):
                raise ValueError(
                    f"`{name}` must be none or one for each of the {len(rest)} rest points, "
                    f"got {len(values)}"
                )
        if len(listed["DeformedPoints"]):
            deformed = listed["DeformedPoints"]
        if len(listed["Weights"]):
            weights = listed["Weights"]
        return rest, rest if deformed is None else deformed, weights


def fill_polydata(polydata, rest, deformed, weights, labels=()):
    """Make control-point polydata, what `arrays.control_points` reads.

    Parameters
    ----------
    polydata : vtkPolyData
        Gets a vertex for each p, the active vectors "Displacement" = q - p, and "Weight" if there
        are weights; float64.
    rest, deformed : (n, 3) float64, world coordinates
    weights : (n,) float64 or None
    labels : list of n str, optional
        Become the point array "Label" if any is not empty.
    """
    points = vtkPoints()
    points.SetData(arrays.from_numpy(rest, VTK_DOUBLE))
    polydata.SetPoints(points)
    vertices = vtkCellArray()
    vertices.SetData(arrays.ids(np.arange(len(rest) + 1)), arrays.ids(np.arange(len(rest))))
    polydata.SetVerts(vertices)
    arrays.add(polydata.GetPointData(), "Displacement", deformed - rest)
    polydata.GetPointData().SetActiveVectors("Displacement")
    if weights is not None:
        arrays.add(polydata.GetPointData(), "Weight", weights)
    if any(labels):
        arrays.add_texts(polydata.GetPointData(), "Label", labels)


def numbers_of(name, values, row):
    """The float64 array of shape (n, *row) of the property `name`."""
    try:
        return real(name, values).reshape(len(values), *row)
    except (TypeError, ValueError):
        expected = "rows of three numbers" if row else "numbers"
        raise ValueError(f"`{name}` must be {expected}, got {shown(values)}") from None
