"""Control points by properties: lists of places and weights, and the polydata they make."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray

from vtk_mls import arrays
from vtk_mls.reals import real, shown

_ORIGIN = (0.0, 0.0, 0.0)


class HandleLists:
    """Properties of an algorithm that has control points of its own.

    Each list can be set as a whole, or, as ParaView does it, by its length and single elements.

    Properties
    ----------
    RestPoints, DeformedPoints : (x, y, z) each, world coordinates
        p, and q where they were dragged to. Without DeformedPoints, q = p.
    Weights : floats, > 0
        A factor for each control point; none if all count alike.
    """

    def __init__(self, **keywords):
        super().__init__(**keywords)
        self._rest_points = []
        self._deformed_points = []
        self._weights = []

    def SetRestPoints(self, points):
        """All p: (n, 3) array_like, world coordinates."""
        self._set("_rest_points", _rows(points))

    def GetRestPoints(self):
        return tuple(self._rest_points)

    def SetNumberOfRestPoints(self, count):
        """Keep the first `count` p; new ones are (0, 0, 0)."""
        self._resize(self._rest_points, count, _ORIGIN)

    def GetNumberOfRestPoints(self):
        return len(self._rest_points)

    def SetRestPoint(self, index, x, y, z):
        """One p; those missing before it are (0, 0, 0)."""
        self._replace(self._rest_points, index, (x, y, z), _ORIGIN)

    def SetDeformedPoints(self, points):
        """All q: (n, 3) array_like, world coordinates."""
        self._set("_deformed_points", _rows(points))

    def GetDeformedPoints(self):
        return tuple(self._deformed_points)

    def SetNumberOfDeformedPoints(self, count):
        """Keep the first `count` q; new ones are (0, 0, 0)."""
        self._resize(self._deformed_points, count, _ORIGIN)

    def GetNumberOfDeformedPoints(self):
        return len(self._deformed_points)

    def SetDeformedPoint(self, index, x, y, z):
        """One q; those missing before it are (0, 0, 0)."""
        self._replace(self._deformed_points, index, (x, y, z), _ORIGIN)

    def SetWeights(self, weights):
        """All factors: (n,) array_like."""
        self._set("_weights", list(weights))

    def GetWeights(self):
        return tuple(self._weights)

    def SetNumberOfWeights(self, count):
        """Keep the first `count` factors; new ones are 1."""
        self._resize(self._weights, count, 1.0)

    def GetNumberOfWeights(self):
        return len(self._weights)

    def SetWeight(self, index, weight):
        """One factor; those missing before it are 1."""
        self._replace(self._weights, index, weight, 1.0)

    def _resize(self, values, count, new):
        if count != len(values):
            values[:] = values[:count] + [new] * (count - len(values))
            self.Modified()

    def _replace(self, values, index, value, new):
        self._resize(values, max(index + 1, len(values)), new)
        if values[index] != value:
            values[index] = value
            self.Modified()

    def _handle_lists(self):
        """The lists as one value that can be compared."""
        return tuple(self._rest_points), tuple(self._deformed_points), tuple(self._weights)

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
            rest = numbers_of("RestPoints", self._rest_points, (3,))
        listed = {
            "DeformedPoints": numbers_of("DeformedPoints", self._deformed_points, (3,)),
            "Weights": numbers_of("Weights", self._weights, ()),
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


def _rows(points):
    points = points.tolist() if isinstance(points, np.ndarray) else points
    return [tuple(point) for point in points]
