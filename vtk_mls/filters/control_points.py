"""A source of control points."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from vtk_mls import Grid, arrays
from vtk_mls.filters.algorithm import Algorithm, numbers

_ORIGIN = (0.0, 0.0, 0.0)


class MLSControlPoints(Algorithm):
    """Makes the control-point polydata that the other filters take on input port 1.

    Points are p (float64), each a vertex; the point vectors "Displacement" are q - p; the point
    array "Weight" is there if weights are given.

    Properties
    ----------
    Mode : {"points", "lattice"}
        Whether p are RestPoints, or LatticeDimensions points filling Bounds, x fastest.
    RestPoints, DeformedPoints : (x, y, z) each, world coordinates
        p and q. Without DeformedPoints, q = p.
    Weights : floats, > 0
        A factor for each control point; none if all count alike.
    LatticeDimensions : (nx, ny, nz)
        A single point lies in the middle.
    Bounds : (xmin, xmax, ymin, ymax, zmin, zmax), world coordinates
    """

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkPolyData")
        self._mode = "points"
        self._rest_points = []
        self._deformed_points = []
        self._weights = []
        self._lattice_dimensions = (3, 3, 3)
        self._bounds = (-1.0, 1.0, -1.0, 1.0, -1.0, 1.0)

    def SetMode(self, mode):
        """ "points" or "lattice"."""
        self._set("_mode", mode)

    def GetMode(self):
        return self._mode

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

    def SetLatticeDimensions(self, *dimensions):
        """Numbers of control points (nx, ny, nz)."""
        self._set("_lattice_dimensions", numbers(dimensions))

    def GetLatticeDimensions(self):
        return self._lattice_dimensions

    def SetBounds(self, *bounds):
        """(xmin, xmax, ymin, ymax, zmin, zmax) of the lattice, world coordinates."""
        self._set("_bounds", numbers(bounds))

    def GetBounds(self):
        return self._bounds

    def RequestData(self, request, inInfo, outInfo):
        if self._mode not in ("points", "lattice"):
            raise ValueError(f"`Mode` must be points or lattice, got {self._mode!r}")
        if self._mode == "lattice":
            rest = self._lattice()
        else:
            rest = _array("RestPoints", self._rest_points, (3,))
        deformed = _array("DeformedPoints", self._deformed_points, (3,))
        weights = _array("Weights", self._weights, ())
        for name, values in (("DeformedPoints", deformed), ("Weights", weights)):
            if len(values) not in (0, len(rest)):
                raise ValueError(
                    f"`{name}` must be none or one for each of the {len(rest)} rest points, "
                    f"got {len(values)}"
                )
        displacement = deformed - rest if len(deformed) else np.zeros_like(rest)
        output = vtkPolyData.GetData(outInfo)
        points = vtkPoints()
        points.SetData(arrays.from_numpy(rest, VTK_DOUBLE))
        output.SetPoints(points)
        vertices = vtkCellArray()
        for number in range(len(rest)):
            vertices.InsertNextCell(1, (number,))
        output.SetVerts(vertices)
        _add(output, "Displacement", displacement)
        output.GetPointData().SetActiveVectors("Displacement")
        if len(weights):
            _add(output, "Weight", weights)
        return 1

    def _resize(self, values, count, new):
        if count != len(values):
            values[:] = values[:count] + [new] * (count - len(values))
            self.Modified()

    def _replace(self, values, index, value, new):
        self._resize(values, max(index + 1, len(values)), new)
        if values[index] != value:
            values[index] = value
            self.Modified()

    def _lattice(self):
        try:
            dimensions = Grid(self._lattice_dimensions).dimensions
        except (TypeError, ValueError):
            raise ValueError(
                "`LatticeDimensions` must be three positive integers (nx, ny, nz), "
                f"got {self._lattice_dimensions!r}"
            ) from None
        bounds = _array("Bounds", self._bounds, ())
        if bounds.shape != (6,) or not (bounds[::2] <= bounds[1::2]).all():
            raise ValueError(
                "`Bounds` must be (xmin, xmax, ymin, ymax, zmin, zmax) with each minimum not above "
                f"its maximum, got {self._bounds!r}"
            )
        low, high = bounds[::2], bounds[1::2]
        axes = [
            np.linspace(a, b, n) if n > 1 else [(a + b) / 2]
            for a, b, n in zip(low, high, dimensions)
        ]
        z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
        return np.stack([x, y, z], axis=-1).reshape(-1, 3)


def _rows(points):
    return [tuple(point) for point in points]


def _array(name, values, row):
    """float64 array of shape (n, *row)."""
    try:
        return np.array(values, dtype=np.float64).reshape(len(values), *row)
    except (TypeError, ValueError):
        expected = "rows of three numbers" if row else "numbers"
        raise ValueError(f"`{name}` must be {expected}, got {values!r:.80}") from None


def _add(output, name, values):
    array = arrays.from_numpy(values, VTK_DOUBLE)
    array.SetName(name)
    output.GetPointData().AddArray(array)
