"""Files by VTK's own readers and writers, whose failures become errors."""

from __future__ import annotations

import errno
import importlib
import os
import re
from contextlib import contextmanager

from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow, vtkVersion
from vtkmodules.vtkCommonMisc import vtkErrorCode

_LONGEST = 200  # characters of what others say in an error


def made(name):
    """A new reader or writer of VTK's, by its module and class: `vtkIOXML.vtkXMLPolyDataReader`.

    Raises
    ------
    ValueError
        If this VTK has none.
    """
    module, _, kind = name.partition(".")
    try:
        return getattr(importlib.import_module(f"vtkmodules.{module}"), kind)()
    except (AttributeError, ImportError):
        raise ValueError(
            f"this VTK, {vtkVersion.GetVTKVersion()}, has no {kind}; that of `pip install vtk` has"
        ) from None


def read(reader, path):
    """What a reader makes of a file."""
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutputDataObject(0)


def write(writer, dataset, path):
    """Write a file."""
    writer.SetInputData(dataset)
    writer.SetFileName(str(path))
    writer.Write()
    code = writer.GetErrorCode()
    if code == vtkErrorCode.OutOfDiskSpaceError:
        raise _disk_full()
    if code:
        raise OSError(vtkErrorCode.GetStringFromErrorCode(code))


def check_size(path, size):
    """Raise OSError if a file has not the bytes that it must have.

    For writers that do not notice it when the disk is full.
    """
    if path.stat().st_size != size:
        raise _disk_full()


@contextmanager
def failures_named(path):
    """What goes wrong, also what VTK only reports, becomes a ValueError that names the file."""
    usual, window = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkOutputWindow.SetInstance(window)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    except MemoryError:
        raise ValueError(f"`{path}` needs more memory than there is") from None
    except (ArithmeticError, ValueError) as error:
        if f"`{path}`" in str(error):
            raise
        raise ValueError(f"`{path}` cannot be used: {_sentence(str(error))}") from error
    finally:
        vtkOutputWindow.SetInstance(usual)
        vtkLogger.SetStderrVerbosity(verbosity)
    errors = _reported(window.GetOutput())
    if errors:
        raise ValueError(f"`{path}`: VTK says: {_sentence(errors[0])}")


def _reported(text):
    """Errors in what VTK has printed, those that say a reason first."""
    if isinstance(text, bytes):  # it quotes a file that is no text
        text = text.decode(errors="replace")
    found = re.findall(r"ERROR: In [^\n]*\n[^\n]*?\): ([^\n]+)", text)
    found = [error for error in found if "did not create output" not in error]  # is seen anyway
    return sorted(found, key=lambda error: "returned failure for request" in error)


def _sentence(text):
    """The beginning of a text on one line, without what is not for reading."""
    text = re.sub(r" \(0x[0-9a-f]+\)", "", " ".join(text.split()))
    text = "".join(each if each.isprintable() else "?" for each in text)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _disk_full():
    return OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
