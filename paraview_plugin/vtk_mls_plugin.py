"""ParaView plugin: MLSDeform, MLSDisplacementField, MLSLandmarkReport, and MLSControlPoints.

In the GUI: Tools > Manage Plugins > Load New, then choose this file.  In pvpython:
`LoadPlugin("/path/to/vtk_mls_plugin.py", ns=globals())`.
"""

import sys
from pathlib import Path

# This file is in <checkout>/paraview_plugin or <site-packages>/vtk_mls/paraview_plugin.  Folders
# are appended to sys.path, not inserted first: a site-packages may have a VTK and a numpy, which
# must not replace ParaView's own.
try:
    import vtk_mls
except ModuleNotFoundError as error:
    if error.name != "vtk_mls":
        raise
# A folder vtk_mls next to the user's script, a clone, is found as a package without a file.
if getattr(sys.modules.get("vtk_mls"), "__file__", None) is None:
    sys.modules.pop("vtk_mls", None)
    _above = Path(__file__).resolve().parents[1]
    sys.path.append(str(_above.parent if (_above / "__init__.py").exists() else _above))
    import vtk_mls

from vtk_mls.paraview import displays, watch
from vtk_mls.paraview.proxies import (  # noqa: F401  ParaView finds them here
    MLSControlPoints,
    MLSDeform,
    MLSDisplacementField,
    MLSImageReader,
    MLSLandmarkReport,
)

displays.add_default_colors()
watch.start()

paraview_plugin_version = vtk_mls.__version__
