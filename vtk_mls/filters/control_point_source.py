"""A source of control points."""

from contextlib import suppress

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls.base.validation import short_repr
from vtk_mls.files import control_point_files, metadata
from vtk_mls.filters import pipeline, property_tables
from vtk_mls.filters.algorithm import Algorithm
from vtk_mls.filters.map_inputs import as_float_rows, listed_control_points
from vtk_mls.filters.properties import with_properties
from vtk_mls.vtk.control_point_polydata import fill_arrows, fill_polydata


@with_properties(property_tables.CONTROL_POINTS)
class MLSControlPoints(Algorithm):
    """Makes the control-point polydata that the other filters take on input port 1.

    Points are p (float64), each a vertex, or a node of a line if a file has curves; the point
    vectors "Displacement" are q - p; the point array "Weight" is there if weights are given, and
    "Label" (texts) if a file has labels. On output port 1 are arrows from p to q, to look at.
    Control points of files are in LPS whatever frame the file is in, and the field array "Space" of
    both outputs says so; those of the other modes are in the frame that they are given in.

    Control points of tables with a column `time` move: the outputs announce these times, and have
    the points of the last one that is not after the requested time.
    """

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=2, outputType="vtkPolyData")

    def RequestInformation(self, request, inInfo, outInfo):
        times = ()
        if self.GetMode() == "file" and self.GetFileName():
            with suppress(OSError, ValueError):  # RequestData reports it
                times = control_point_files.times(self.GetFileName(), self.GetDeformedFileName())
        for port in range(2):
            pipeline.announce_times(outInfo.GetInformationObject(port), times)
        return 1

    def RequestData(self, request, inInfo, outInfo):
        requested = [pipeline.requested_time(outInfo.GetInformationObject(i)) for i in range(2)]
        time = next((time for time in requested if time is not None), -np.inf)
        mode, defaults, labels, cells = property_tables.MODE.checked(self), (), (), None
        if mode == "lattice":
            defaults = (self._lattice(),)
        elif mode == "file":
            *defaults, labels, cells, _ = self._read_pairs(time)
        rest, deformed, weights = listed_control_points(self, *defaults)
        points, arrows = vtkPolyData.GetData(outInfo), vtkPolyData.GetData(outInfo, 1)
        fill_polydata(points, rest, deformed, weights, labels, cells)
        fill_arrows(arrows, rest, deformed)
        if mode == "file":
            for index, polydata in enumerate((points, arrows)):
                metadata.store(polydata, metadata.SPACE, ["LPS"])
                pipeline.stamp_step(outInfo.GetInformationObject(index), time)
        return 1

    def _read_pairs(self, time):
        if not self.GetFileName():
            raise ValueError("`FileName` must name a file with control points: choose one")
        space = property_tables.SPACE.checked(self)
        try:
            return control_point_files.read_pairs(
                self.GetFileName(), self.GetDeformedFileName(), space, time
            )
        except OSError as error:
            raise ValueError(f"`FileName`: {error}") from error

    def _lattice(self):
        dimensions = property_tables.LATTICE_DIMENSIONS.checked(self)
        bounds = as_float_rows("Bounds", self.GetBounds(), ())
        if bounds.shape != (6,) or not (bounds[::2] <= bounds[1::2]).all():
            raise ValueError(
                "`Bounds` must be (xmin, xmax, ymin, ymax, zmin, zmax) with each minimum not above "
                f"its maximum, got {short_repr(self.GetBounds())}"
            )
        return lattice(dimensions, bounds)


def lattice(dimensions, bounds):
    """Places (nx * ny * nz, 3) that fill a box regularly, x fastest.

    `bounds` are (xmin, xmax, ymin, ymax, zmin, zmax); a single one is in the middle of its axis.
    """
    axes = [
        np.linspace(low, high, count) if count > 1 else [(low + high) / 2]
        for low, high, count in zip(bounds[::2], bounds[1::2], dimensions)
    ]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    return np.stack([x, y, z], axis=-1).reshape(-1, 3)
