"""Arrows that show where control points were dragged."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkGlyph3D
from vtkmodules.vtkFiltersSources import vtkArrowSource

from vtk_mls.vtk.control_point_polydata import DISPLACEMENT, fill_polydata
from vtk_mls.vtk.objects import output_of


def fill_arrows(polydata, rest, deformed):
    """Fill polydata with arrows from p to q, (n, 3) each, world coordinates.

    They have the point vectors "Displacement". There is none for control points that stay, or whose
    displacement is not finite.
    """
    displacement = deformed - rest
    moved = np.isfinite(displacement).all(axis=1) & displacement.any(axis=1)
    if not moved.any():
        return
    handles, glyphs = vtkPolyData(), vtkGlyph3D()
    fill_polydata(handles, rest[moved], deformed[moved], None)
    glyphs.SetScaleModeToScaleByVector()
    arrow = output_of(vtkArrowSource())
    polydata.ShallowCopy(output_of(glyphs, InputData=handles, SourceData=arrow))
    polydata.GetPointData().GetArray("GlyphVector").SetName(DISPLACEMENT)
