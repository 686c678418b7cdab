"""Control points as point sets of VTK."""

from __future__ import annotations

from pathlib import Path

from vtkmodules.vtkCommonDataModel import vtkPointSet

from vtk_mls.base import validation
from vtk_mls.files import provenance
from vtk_mls.files.landmarks import Landmarks
from vtk_mls.vtk import arrays

_DISPLACEMENT, _WEIGHT, _LABEL = "Displacement", "Weight", "Label"


def landmarks(path: Path, point_set: vtkPointSet, is_alone: bool) -> Landmarks:
    """Its points, in its frame; they must have partners if it `is_alone`."""
    data, partners = point_set.GetPointData(), None
    weight = _WEIGHT if data.HasArray(_WEIGHT) else None
    if is_alone or data.HasArray(_DISPLACEMENT):
        points, partners, weights = arrays.control_points(point_set, _DISPLACEMENT, weight)
        validation.points("deformed", partners)
    else:
        points = arrays.to_numpy(point_set.GetPoints().GetData()).astype(float)
        weights = weight and arrays.to_numpy(data.GetArray(weight)).astype(float)
    validation.points("rest", points)
    is_lps = bool(provenance.kept(point_set, provenance.FILE_SPACE))
    frame = "LPS" if is_lps else "".join(provenance.kept(point_set, provenance.SPACE))
    labels = arrays.texts(data, _LABEL)
    return Landmarks(path, points, frame, labels, partners=partners, weights=weights)
