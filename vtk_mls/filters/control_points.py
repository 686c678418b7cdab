"""A source of control points."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls import Grid, handle_files
from vtk_mls.filters.algorithm import Algorithm, numbers
from vtk_mls.filters.handle_arrows import fill_arrows
from vtk_mls.filters.handle_lists import HandleLists, fill_polydata, numbers_of
from vtk_mls.reals import shown


class MLSControlPoints(HandleLists, Algorithm):
    """Makes the control-point polydata that the other filters take on input port 1.

    Points are p (float64), each a vertex; the point vectors "Displacement" are q - p; the point
    array "Weight" is there if weights are given. On output port 1 are arrows from p to q, to look
    at.

    Properties
    ----------
    Mode : {"points", "lattice", "file"}
        Whether p are RestPoints, or LatticeDimensions points filling Bounds, x fastest, or those
        of a file.
    RestPoints, DeformedPoints, Weights
        See `HandleLists`. Unless they are empty, DeformedPoints and Weights are used in every mode.
    FileName, DeformedFileName : str
        Of what `handle_files.read` can read. The deformed positions q are what is p in the second
        file, if there is one.
    LatticeDimensions : (nx, ny, nz)
        A single point lies in the middle.
    Bounds : (xmin, xmax, ymin, ymax, zmin, zmax), world coordinates
    """

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=2, outputType="vtkPolyData")
        self._mode = "points"
        self._file_name = ""
        self._deformed_file_name = ""
        self._lattice_dimensions = (3, 3, 3)
        self._bounds = (-1.0, 1.0, -1.0, 1.0, -1.0, 1.0)

    def SetMode(self, mode):
        """ "points", "lattice" or "file"."""
        self._set("_mode", mode)

    def GetMode(self):
        return self._mode

    def SetFileName(self, name):
        """File with control points."""
        self._set("_file_name", name or "")

    def GetFileName(self):
        return self._file_name

    def SetDeformedFileName(self, name):
        """File with the places that control points were moved to, "" for none."""
        self._set("_deformed_file_name", name or "")

    def GetDeformedFileName(self):
        return self._deformed_file_name

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
        defaults = {"points": tuple, "lattice": self._lattice, "file": self._filed}
        if self._mode not in defaults:
            raise ValueError(
                f"`Mode` must be one of {', '.join(defaults)}, got {shown(self._mode)}"
            )
        rest, deformed, weights = self._handles(*defaults[self._mode]())
        fill_polydata(vtkPolyData.GetData(outInfo), rest, deformed, weights)
        fill_arrows(vtkPolyData.GetData(outInfo, 1), rest, deformed)
        return 1

    def _filed(self):
        """p, q and weights of the files."""
        try:
            return handle_files.read(self._file_name, self._deformed_file_name)
        except OSError as error:
            raise ValueError(f"`FileName`: {error}") from error

    def _lattice(self):
        """p that fill the box."""
        try:
            dimensions = Grid(self._lattice_dimensions).dimensions
        except (TypeError, ValueError):
            raise ValueError(
                "`LatticeDimensions` must be three positive integers (nx, ny, nz), "
                f"got {shown(self._lattice_dimensions)}"
            ) from None
        bounds = numbers_of("Bounds", self._bounds, ())
        if bounds.shape != (6,) or not (bounds[::2] <= bounds[1::2]).all():
            raise ValueError(
                "`Bounds` must be (xmin, xmax, ymin, ymax, zmin, zmax) with each minimum not above "
                f"its maximum, got {shown(self._bounds)}"
            )
        return (lattice(dimensions, bounds),)


def lattice(dimensions, bounds):
    """Places that fill a box regularly; a single one along an axis lies in the middle.

    Parameters
    ----------
    dimensions : (nx, ny, nz)
    bounds : (xmin, xmax, ymin, ymax, zmin, zmax)

    Returns
    -------
    (nx * ny * nz, 3) float64
        x fastest.
    """
    axes = [
        np.linspace(low, high, count) if count > 1 else [(low + high) / 2]
        for low, high, count in zip(bounds[::2], bounds[1::2], dimensions)
    ]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    return np.stack([x, y, z], axis=-1).reshape(-1, 3)
