"""Files of simulation programs, of several blocks, and of several time steps.

VTK has readers for most formats, in modules that not every VTK has: they are imported when they are
needed. Others are read by meshio, if it is installed.
"""

from __future__ import annotations

import contextlib
import io
import re
import tempfile
from pathlib import Path
from xml.sax.saxutils import unescape

from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from vtk_mls.files import volumes, vtk_io

# Names of other files in those that name some.
_NAMES = {
    "xml": re.compile(r"""\b(?:file|Source)\s*=\s*(?:"([^"]*)"|'([^']*)')"""),
    "case": re.compile(r"^[^:\n]*:.*?([^\s:]+)\s*$", re.MULTILINE),
    "xdmf": re.compile(r"[>\s]([^<>\s:]+\.(?:h5|hdf5?|bin|raw)\b)"),
}


def open_file(reader, syntax, path):
    """What a file holds, to be read when it is wanted.

    Parameters
    ----------
    reader : str
        Module and class of VTK's reader.
    syntax : {"xml", "case", "xdmf", "none"}
        How the file names others, which must be there, and in its folder.
    path : Path

    Returns
    -------
    times : tuple of float
        Of its time steps; empty if it says none.
    read : callable
        Gives the dataset of a time step by its number. None, or a dataset of any kind, if the file
        is broken: VTK's output window has heard why.

    Raises
    ------
    ValueError
    """
    if syntax in _NAMES:
        _check_names(path, syntax)
    reader = vtk_io.made(reader)
    if hasattr(reader, "SetScanForRelatedFiles"):
        reader.SetScanForRelatedFiles(False)
    if hasattr(reader, "SetCaseFileName"):
        reader.SetCaseFileName(str(path))
    else:
        reader.SetFileName(str(path))
    if not reader.GetExecutive().UpdateInformation():
        return (), lambda number: None
    if hasattr(reader, "EnableAllPointArrays"):
        reader.EnableAllPointArrays()
        reader.EnableAllCellArrays()
    key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    times = tuple(reader.GetOutputInformation(0).Get(key) or ())

    def read(number):
        done = reader.UpdateTimeStep(times[number]) if times else reader.GetExecutive().Update()
        data = reader.GetOutputDataObject(0)
        if not done or data is None:
            return None
        copy = data.NewInstance()  # the reader's own is used for the next step
        copy.ShallowCopy(data)
        return copy

    return times, read


def _check_names(path, syntax):
    """Raise if a file names others that are not there, or not in its folder."""
    for found in _NAMES[syntax].finditer(path.read_text("utf-8", "replace")):
        name = found[found.lastindex]
        if syntax == "xml":
            volumes.named_file(path, unescape(name, {"&quot;": '"', "&apos;": "'"}))
        else:
            volumes.check_within(name)


def read_by_meshio(path):
    """A mesh as meshio reads it, by way of a file that both know."""
    try:
        import meshio
    except ImportError:
        raise ValueError(
            "it is read by meshio, which is not installed: pip install meshio"
        ) from None
    said = io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        between = Path(folder) / "mesh.vtu"
        with contextlib.redirect_stdout(said):
            try:
                meshio.read(path).write(between, compression=None)
            # whatever its parsers stumble over in a broken file; it even exits
            except (Exception, SystemExit) as error:
                reason = str(error) if isinstance(error, Exception) else said.getvalue()
                if isinstance(error, ImportError):
                    reason += f": pip install {error.name}"
                raise ValueError(f"meshio says: {reason or type(error).__name__}") from None
        return vtk_io.read(vtkXMLUnstructuredGridReader(), between)
