"""Defaults that ParaView takes from its settings, also for *Restore Defaults*.

ParaView would choose arrays of the input for lists of arrays, and the range of the data for the
color map of the array JacobianDeterminant, which is that of the editor: red in folds.
"""

from __future__ import annotations

import json

from paraview.modules.vtkRemotingServerManager import vtkSMSettings

from vtk_mls.filters import property_tables as tables
from vtk_mls.filters.properties import ArrayNames
from vtk_mls.paraview.panels import CONTROL_POINT_ARRAYS
from vtk_mls.rendering import volume_colors
from vtk_mls.rendering.rest_surface import DETERMINANT

ARRAY_LISTS = tuple(prop.name for prop in tables.DEFORM if isinstance(prop, ArrayNames))
_PRIORITY = 0.5  # below the settings of the site and of the user


def add():
    """Make them ParaView's defaults, unless the user has set others."""
    arrays = dict.fromkeys(("MLSDisplacementField", "MLSLandmarkReport"), CONTROL_POINT_ARRAYS)
    arrays["MLSDeform"] = {key: [] for key in ARRAY_LISTS} | CONTROL_POINT_ARRAYS
    points = volume_colors.table()
    table = {
        "RGBPoints": points.ravel().tolist(),
        "ColorSpace": 0,  # RGB
        "NumberOfTableValues": volume_colors.TABLE_SIZE,
        "ScalarRangeInitialized": 1,
        "AutomaticRescaleRangeMode": -1,  # never, so that white always is the volume at rest
    }
    settings = {"array_lookup_tables": {DETERMINANT: {"PVLookupTable": table}}, "filters": arrays}
    vtkSMSettings.GetInstance().AddCollectionFromString(json.dumps(settings), _PRIORITY)
