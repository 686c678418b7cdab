"""The default color map of the array JacobianDeterminant: that of the editor, red in folds."""

import json

from paraview.modules.vtkRemotingServerManager import vtkSMSettings

from vtk_mls.rendering import volume_colors
from vtk_mls.rendering.rest_surface import DETERMINANT

_PRIORITY = 1.5  # above the settings of the site, below those of the user


def add_defaults():
    """Make it ParaView's default, unless the user has set another one for arrays of this name.

    The range does not follow the data, so that white always is the volume at rest.
    """
    points = volume_colors.table()
    table = {
        "RGBPoints": points.ravel().tolist(),
        "ColorSpace": 0,  # RGB
        "NumberOfTableValues": volume_colors.TABLE_SIZE,
        "ScalarRangeInitialized": 1,
        "AutomaticRescaleRangeMode": -1,  # never
    }
    settings = {"array_lookup_tables": {DETERMINANT: {"PVLookupTable": table}}}
    vtkSMSettings.GetInstance().AddCollectionFromString(json.dumps(settings), _PRIORITY)
