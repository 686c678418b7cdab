"""Arrows that show where control points were dragged."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkGlyph3D
from vtkmodules.vtkFiltersSources import vtkArrowSource

from vtk_mls.vtk.control_point_polydata import DISPLACEMENT, fill_polydata


def fill_arrows(polydata, rest, deformed):
    """Fill polydata with arrows from p to q, (n, 3) each, world coordinates.

    They have the point vectors "Displacement". There is none for control points that stay, or whose
    displacement is not finite.
    """
    displacement = deformed - rest
    moved = np.isfinite(displacement).all(axis=1) & displacement.any(axis=1)
    if not moved.any():
        return
    handles, glyphs, arrow = vtkPolyData(), vtkGlyph3D(), vtkArrowSource()
    arrow.Update()
    fill_polydata(handles, rest[moved], deformed[moved], None)
    glyphs.SetInputData(handles)
    glyphs.SetSourceData(arrow.GetOutput())
    glyphs.SetScaleModeToScaleByVector()
    glyphs.Update()
    polydata.ShallowCopy(glyphs.GetOutput())
    polydata.GetPointData().GetArray("GlyphVector").SetName(DISPLACEMENT)
