"""What `make demo` runs: a frog deformed by each kind, and a brain cut open.

    python examples/demo/make_demo.py DIRECTORY

You will see files and pictures in the directory.
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLImageDataWriter, vtkXMLPolyDataWriter

from vtk_mls import KINDS, DeviceError
from vtk_mls.commands import demo
from vtk_mls.engine.dispatch import engine_for
from vtk_mls.filters import MLSControlPoints, MLSDeform

# Rest position and drag in the volume's coordinates: x to the head, y to the right, z to the belly.
CONTROL_POINTS = {
    "snout": [(470, 227, 35), (10, 35, 0)],
    "brow": [(390, 227, 21), (0, 0, 0)],
    "left shoulder": [(311, 158, 39), (0, 0, 0)],
    "right shoulder": [(311, 308, 44), (0, 0, 0)],
    "left elbow": [(241, 87, 96), (60, -25, 0)],
    "right elbow": [(237, 371, 102), (60, 25, 0)],
    "left hand": [(305, 79, 162), (105, -25, 0)],
    "right hand": [(300, 388, 170), (105, 25, 0)],
    "spine": [(241, 229, 117), (0, 0, 0)],
    "sacrum": [(170, 229, 96), (0, 0, 0)],
    "tail": [(85, 229, 158), (0, 0, 0)],
    "left knee": [(178, 38, 162), (-10, -15, 0)],
    "right knee": [(178, 431, 168), (-10, 15, 0)],
    "left heel": [(41, 90, 176), (-70, -30, 0)],
    "right heel": [(38, 375, 160), (-70, 30, 0)],
}
# Of the deformed frog, in the same coordinates.
LOWER, UPPER = np.array([-60.0, -60.0, -30.0]), np.array([560.0, 530.0, 234.0])

_NO_PICTURE = (
    "No picture: VTK could not draw here. The .vti files are complete; for the picture install "
    "OpenGL for machines without a display, `apt-get install libegl1 libgl1-mesa-dri`, and run "
    "the demo again."
)


def main(directory):
    """Deform the frog and leave .vti files, the control points and a picture in `directory`.

    Parameters
    ----------
    directory : path
        Made if it is not there.

    Raises
    ------
    FileNotFoundError
        If the package that carries the volume is not installed.
    """
    engine = _engine()
    slow = engine is engine_for("reference")
    frog = vtkXMLImageDataReader()
    frog.SetFileName(str(demo.file_of("pyvista", "examples/frog_tissues.vti", "0.44")))
    frog.Update()
    labels = frog.GetOutput().GetPointData().GetScalars().GetName()
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)

    source = MLSControlPoints()
    rest, drag = np.array(list(CONTROL_POINTS.values()), dtype=float).swapaxes(0, 1)
    source.SetRestPoints(rest.tolist())
    source.SetDeformedPoints((rest + drag).tolist())

    spacing = np.array(frog.GetOutput().GetSpacing())
    if slow:
        spacing = 4 * spacing  # some microseconds for each voxel
    dimensions = (np.ceil((UPPER - LOWER) / spacing) + 1).astype(int)

    deform = MLSDeform()
    deform.SetInputConnection(0, frog.GetOutputPort())
    deform.SetInputConnection(1, source.GetOutputPort())
    deform.AddLabelArray(labels)
    deform.SetAlpha(1)  # each limb turns as a whole
    deform.SetOutputGrid("given")
    if slow:
        deform.SetDevice("reference")
    deform.SetOutputOrigin(*LOWER)
    deform.SetOutputSpacing(*spacing)

    size = " x ".join(str(n) for n in frog.GetOutput().GetDimensions())
    print(
        f"A frog of {size} voxels, {len(rest)} handles, {np.any(drag, axis=1).sum()} of them moved,"
    )
    print(f"deformed onto {' x '.join(str(n) for n in dimensions)} voxels by {engine.NAME}")
    _write(vtkXMLImageDataWriter(), frog, directory / "original.vti")
    _write(vtkXMLPolyDataWriter(), source, directory / "handles.vtp")
    _deform_by_each_kind(deform, dimensions, directory)
    print(f"Wrote original.vti, handles.vtp and one .vti for each kind in {directory}")
    draw(directory)
    if slow:
        print("The rest of the demo, a brain cut open, needs OpenCL and is left out.")
    else:
        cut_open(directory)


def _deform_by_each_kind(deform, dimensions, directory):
    """Write the output for each kind of map, and print the time."""
    for kind in KINDS:
        deform.SetKind(kind)
        deform.SetOutputDimensions(8, 8, 8)  # builds the kernels
        deform.Update()
        deform.SetOutputDimensions(*(int(n) for n in dimensions))
        start = time.perf_counter()
        deform.Update()
        seconds = time.perf_counter() - start
        rate = dimensions.prod() / seconds / 1e6
        print(f"  {kind:<10} {1000 * seconds:8.0f} ms   {rate:6.1f} million voxels/s", flush=True)
        _write(vtkXMLImageDataWriter(), deform, directory / f"{kind}.vti")


def draw(directory):
    """Draw the files in `directory` to demo.png there; say what to install if that fails.

    Parameters
    ----------
    directory : Path
    """
    _run("frog_picture", directory / "demo.png")


def cut_open(directory):
    """Cut a brain open; say what to install if that fails.

    Parameters
    ----------
    directory : Path
    """
    try:
        demo.brain_file()
    except FileNotFoundError as error:
        print(f"No brain is cut open: {error}")
        return
    print("A brain (brain.vti) of 197 x 233 x 189 voxels, cut and pulled open (cut.vti)")
    _run("brain_picture", directory / "cut.png")


def _run(script, picture):
    """Draw a picture in a process of its own."""
    picture.unlink(missing_ok=True)
    command = [sys.executable, str(Path(__file__).with_name(f"{script}.py")), str(picture.parent)]
    subprocess.run(command, capture_output=True, check=False)
    print(f"Picture: {picture}" if picture.is_file() else _NO_PICTURE)


def _engine():
    """The engine of the chosen device; without OpenCL, said loudly, the numpy reference."""
    try:
        engine = engine_for()
    except DeviceError as error:
        print(f"No OpenCL: {error}")
        engine = engine_for("reference")
    if engine is engine_for("reference"):
        print("The demo goes on without OpenCL, slowly and on a coarser grid.")
    return engine


def _write(writer, source, file):
    writer.SetInputConnection(source.GetOutputPort())
    writer.SetFileName(str(file))
    writer.Write()


if __name__ == "__main__":
    main(sys.argv[1])
