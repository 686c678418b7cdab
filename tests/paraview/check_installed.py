"""The plugin works inside an installed wheel, whose folder has another numpy and VTK as well."""

import shutil
import sys
import tempfile
from pathlib import Path

from paraview import servermanager, simple

PROJECT = Path(__file__).resolve().parents[2]

with tempfile.TemporaryDirectory() as folder:
    packages = Path(folder) / "site-packages"
    shutil.copytree(PROJECT / "vtk_mls", packages / "vtk_mls")
    for name in ("opencl", "paraview_plugin"):
        shutil.copytree(PROJECT / name, packages / "vtk_mls" / name)
    for name in ("numpy", "vtkmodules", "pyopencl"):
        (packages / name).mkdir()
        (packages / name / "__init__.py").write_text(f"raise RuntimeError('not the {name} to use')")

    plugin = packages / "vtk_mls" / "paraview_plugin" / "vtk_mls_plugin.py"
    simple.LoadPlugin(str(plugin), ns=vars(simple))
    deform = simple.MLSDeform(Input=simple.Wavelet(), ControlPoints=simple.MLSControlPoints())
    deform.UpdatePipeline()
    assert servermanager.Fetch(deform).GetNumberOfPoints() == 21**3

    import vtk_mls

    assert Path(vtk_mls.__file__).parent == packages.resolve() / "vtk_mls"
    assert sys.path.index(str(packages.resolve())) > sys.path.index(
        "/usr/lib/python3/dist-packages"
    )
