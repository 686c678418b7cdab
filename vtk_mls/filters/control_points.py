"""A source of control points."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls import Grid
from vtk_mls.files import control_point_files, provenance
from vtk_mls.filters.algorithm import Algorithm, numbers
from vtk_mls.filters.handle_arrows import fill_arrows
from vtk_mls.filters.handle_lists import HandleLists, fill_polydata, numbers_of
from vtk_mls.reals import shown

_MODES = ("points", "lattice", "file")


class MLSControlPoints(HandleLists, Algorithm):
    """Makes the control-point polydata that the other filters take on input port 1.

    Points are p (float64), each a vertex; the point vectors "Displacement" are q - p; the point
    array "Weight" is there if weights are given, and "Label" (texts) if a file has labels. On
    output port 1 are arrows from p to q, to look at. Control points of files are in LPS whatever
    frame the file is in, and the field array "Space" of both outputs says so; those of the other
    modes are in the frame that they are given in.

    Properties
    ----------
    Mode : {"points", "lattice", "file"}
        Whether p are RestPoints, or LatticeDimensions points filling Bounds, x fastest, or those
        of a file.
    RestPoints, DeformedPoints, Weights
        See `HandleLists`. Unless they are empty, DeformedPoints and Weights are used in every mode.
    FileName, DeformedFileName : str
        Of what `control_point_files.read` can read. If there is a second file, its places are the
        deformed positions q, by their labels or else in its order (see `landmarks.paired`).
    Space : {"lps", "ras"}
        The frame of files that do not say theirs: .fcsv, .mrk.json, and .csv with columns l,p,s or
        r,a,s do.
    LatticeDimensions : (nx, ny, nz)
        A single point lies in the middle.
    Bounds : (xmin, xmax, ymin, ymax, zmin, zmax), world coordinates
    """

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=2, outputType="vtkPolyData")
        self._mode = "points"
        self._file_name = ""
        self._deformed_file_name = ""
        self._space = "lps"
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

    def SetSpace(self, space):
        """ "lps" or "ras": the frame of files that do not say theirs."""
        self._set("_space", space)

    def GetSpace(self):
        return self._space

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
        if self._mode not in _MODES:
            raise ValueError(f"`Mode` must be one of {', '.join(_MODES)}, got {shown(self._mode)}")
        defaults, labels = (), ()
        if self._mode == "lattice":
            defaults = (self._lattice(),)
        elif self._mode == "file":
            filed = self._filed()
            defaults, labels = (filed.rest, filed.deformed, filed.weights), filed.labels
        rest, deformed, weights = self._handles(*defaults)
        handles, arrows = vtkPolyData.GetData(outInfo), vtkPolyData.GetData(outInfo, 1)
        fill_polydata(handles, rest, deformed, weights, labels)
        fill_arrows(arrows, rest, deformed)
        if self._mode == "file":
            for polydata in (handles, arrows):
                provenance.keep(polydata, provenance.SPACE, ["LPS"])
        return 1

    def _filed(self):
        """p, q, weights and labels of the files."""
        if self._space not in ("lps", "ras"):
            raise ValueError(f"`Space` must be one of lps, ras, got {shown(self._space)}")
        try:
            return control_point_files.read_pairs(
                self._file_name, self._deformed_file_name, self._space
            )
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
        return lattice(dimensions, bounds)


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
