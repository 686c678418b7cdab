"""Files of simulation programs, of several blocks, and of several time steps.

VTK has readers for most formats, in modules that some builds lack, so they are imported when they
are needed. meshio reads the others, if it is installed.
"""

import contextlib
import io
import re
import tempfile
from pathlib import Path
from xml.sax.saxutils import unescape

from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from vtk_mls.files import paths, vtk_io

# Names of other files in a file.
_NAMES = {
    "xml": re.compile(r"""\b(?:file|Source)\s*=\s*(?:"([^"]*)"|'([^']*)')"""),
    "case": re.compile(r"^[^:\n]*:.*?([^\s:]+)\s*$", re.MULTILINE),
    "xdmf": re.compile(r"[>\s]([^<>\s:]+\.(?:h5|hdf5?|bin|raw)\b)"),
}


def open_file(reader, syntax, path):
    """The time steps of a file, () without, and a function that returns the dataset of one by its
    index.

    `reader` is the module and class of VTK's reader. `syntax` ("xml", "case", "xdmf" or "none")
    says how the file names other files, which must exist in its folder. Of a broken file the
    function returns None or any dataset, with the reason in VTK's output window.
    """
    if syntax in _NAMES:
        _check_names(path, syntax)
    reader = vtk_io.create(reader)
    if hasattr(reader, "SetScanForRelatedFiles"):
        reader.SetScanForRelatedFiles(False)
    if hasattr(reader, "SetCaseFileName"):
        reader.SetCaseFileName(str(path))
    else:
        reader.SetFileName(str(path))
    if not reader.GetExecutive().UpdateInformation():
        return (), lambda index: None
    if hasattr(reader, "EnableAllPointArrays"):
        reader.EnableAllPointArrays()
        reader.EnableAllCellArrays()
    key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    times = tuple(reader.GetOutputInformation(0).Get(key) or ())

    def read(index):
        success = reader.UpdateTimeStep(times[index]) if times else reader.GetExecutive().Update()
        data = reader.GetOutputDataObject(0)
        if not success or data is None:
            return None
        copy = data.NewInstance()  # the reader writes the next step to its own
        copy.ShallowCopy(data)
        return copy

    return times, read


def _check_names(path, syntax):
    """Raise ValueError if a file names others that are missing or outside of its folder."""
    for match in _NAMES[syntax].finditer(path.read_text("utf-8", "replace")):
        name = match[match.lastindex]
        if syntax == "xml":
            paths.named_file(path, unescape(name, {"&quot;": '"', "&apos;": "'"}))
        else:
            paths.check_within(name)


def read_by_meshio(path):
    """Read a mesh with meshio, through a .vtu file."""
    import meshio

    printed = io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        vtu_path = Path(folder) / "mesh.vtu"
        with contextlib.redirect_stdout(printed):
            try:
                meshio.read(path).write(vtu_path, compression=None)
            # its parsers raise anything on broken files, and even exit
            except (Exception, SystemExit) as error:
                reason = str(error) if isinstance(error, Exception) else printed.getvalue()
                if isinstance(error, ImportError):
                    reason += f": pip install {error.name}"
                raise ValueError(f"meshio says: {reason or type(error).__name__}") from None
        return vtk_io.read(vtkXMLUnstructuredGridReader(), vtu_path)
