"""Run by the Python of an empty environment: what users do first works there.

A volume and a mesh are cut and deformed, by an OpenCL device and by the specification, and a file
by the command.
"""

import platform
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonDataModel import VTK_TETRA
from vtkmodules.vtkFiltersSources import vtkCellTypeSource
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

import vtk_mls
from vtk_mls import io
from vtk_mls.engine import dispatch
from vtk_mls.engine.device import device_check, devices
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of

# Of PyPI's PoCL, whose LLVM of 2022 does not know newer ones.
UNKNOWN_PROCESSOR = "unknown target CPU"
REST = [(0, 0, 0), (8, 0, 0), (0, 8, 0), (0, 0, 8), (8, 8, 8), (8, 8, 0)]
DEFORMED = [(0, 0, 0), (12, 0, 1), (0, 8, 0), (0, 0, 8), (9, 8, 8), (8, 9, 0)]
CUT = vtk_mls.HalfPlane((5, 5, 4), (1, 0, 0), (0, 0, 1))


def volume():
    source = vtkRTAnalyticSource()
    source.SetWholeExtent(0, 8, 0, 8, 0, 8)
    return output_of(source)


def mesh():
    source = configured(vtkCellTypeSource(), CellType=VTK_TETRA)
    source.SetBlocksDimensions(8, 8, 8)
    return output_of(source)


def deformed(dataset, device):
    deform = configured(MLSDeform(), InputData=dataset, Device=device)
    configured(deform, RestPoints=REST, DeformedPoints=DEFORMED).AddCut(CUT)
    assert deform.GetExecutive().Update(), f"{dataset.GetClassName()} by {device}"
    return deform.GetOutputDataObject(0)


def main():
    assert Path(vtk_mls.__file__).resolve().is_relative_to(sys.argv[1]), vtk_mls.__file__
    own, note = devices.find()[0][-1], ""  # PyPI's driver comes after those of the system
    (result,) = device_check.results([own])
    if UNKNOWN_PROCESSOR in (result.failure or ""):
        own, note = dispatch.choose(), f" (for {own} knows no such processor)"
    engines = own.key, "reference"
    images = [deformed(volume(), engine).GetPointData() for engine in engines]
    values = [arrays.to_numpy(image.GetArray("RTData")) for image in images]
    voids = [arrays.to_numpy(image.GetArray("Void")) for image in images]
    assert voids[0].any()
    np.testing.assert_array_equal(*voids)
    np.testing.assert_allclose(*values, atol=0.1)  # they range over 200
    meshes = [deformed(mesh(), engine) for engine in engines]
    places = [arrays.to_numpy(mesh.GetPoints().GetData()) for mesh in meshes]
    assert len(places[0]) > mesh().GetNumberOfPoints()  # doubled along the cut
    np.testing.assert_allclose(*places, atol=1e-4)

    with tempfile.TemporaryDirectory() as folder:
        io.write_dataset(volume(), f"{folder}/in.nii.gz")
        rows = "".join(f"{str(p + q)[1:-1]}\n" for p, q in zip(REST, DEFORMED))
        Path(folder, "handles.csv").write_text(f"px,py,pz,qx,qy,qz\n{rows}")
        command = ["deform", "in.nii.gz", "handles.csv", "out.nii.gz"]
        subprocess.run([sys.executable, "-m", "vtk_mls", *command], cwd=folder, check=True)
        assert io.read_dataset(f"{folder}/out.nii.gz").GetDimensions() == (9, 9, 9)

    versions = platform.python_version(), np.__version__, vtkVersion.GetVTKVersion()
    print(f"WORKS: | {' | '.join(versions)} | {own}{note} |")


if __name__ == "__main__":
    main()
