"""VTK's own readers and writers, whose failures become errors."""

import errno
import importlib
import os
import re
from contextlib import contextmanager

from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow, vtkVersion
from vtkmodules.vtkCommonMisc import vtkErrorCode

from vtk_mls.base.errors import InputError
from vtk_mls.files.paths import replacing

_MAX_TEXT = 200  # characters of a quoted error


def create(name):
    """A new reader or writer by module and class, such as `vtkIOXML.vtkXMLPolyDataReader`; a
    ValueError says that this VTK has none.
    """
    module, _, kind = name.partition(".")
    try:
        return getattr(importlib.import_module(f"vtkmodules.{module}"), kind)()
    except (AttributeError, ImportError):
        raise ValueError(
            f"this VTK, {vtkVersion.GetVTKVersion()}, has no {kind}; `pip install vtk` does"
        ) from None


def read(reader, path):
    """The output of a reader."""
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


def write_png(picture, path):
    """Write a vtkImageData as a .png file. An old file is replaced when the new one is complete."""
    writer = create("vtkIOImage.vtkPNGWriter")
    writer.SetInputData(picture)
    writer.WriteToMemoryOn()  # to a file, it does not say why it fails
    writer.Write()
    with replacing(path) as new:
        new.write_bytes(memoryview(writer.GetResult()))


def check_size(path, size):
    """Raise OSError unless a file has so many bytes, for writers that miss a full disk."""
    if path.stat().st_size != size:
        raise _disk_full()


@contextmanager
def failures_named(path):
    """Turn errors, also those that VTK only prints, into an InputError of the file."""
    default_window, window = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkOutputWindow.SetInstance(window)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    except MemoryError:
        raise InputError("needs more memory than there is", path=path) from None
    except (ArithmeticError, ValueError) as error:
        if getattr(error, "path", ""):
            raise
        predicate = f"cannot be used: {_sentence(str(error))}"
        if isinstance(error, InputError) and not error.name:
            predicate = error.predicate
        raise InputError(predicate, path=path) from error
    finally:
        vtkOutputWindow.SetInstance(default_window)
        vtkLogger.SetStderrVerbosity(verbosity)
    errors = _reported(window.GetOutput())
    if errors:
        raise InputError(f": VTK says: {_sentence(errors[0])}", path=path)


def _reported(text):
    """Errors that VTK has printed, those with a reason first."""
    if isinstance(text, bytes):  # it quotes a binary file
        text = text.decode(errors="replace")
    errors = re.findall(r"ERROR: In [^\n]*\n[^\n]*?\): ([^\n]+)", text)
    errors = [error for error in errors if "did not create output" not in error]  # no reason
    return sorted(errors, key=lambda error: "returned failure for request" in error)


def _sentence(text):
    """The beginning of a text on one line.

    Addresses, folders of `paths.replacing` and control characters are left out.
    """
    text = re.sub(r" \(0x[0-9a-f]+\)|\.vtk-mls-\d+-\w+[/\\]", "", " ".join(text.split()))
    text = "".join(letter if letter.isprintable() else "?" for letter in text)
    return text if len(text) <= _MAX_TEXT else f"{text[:_MAX_TEXT]}..."


def _disk_full():
    return OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
