"""ITK's transform files (.h5 .hdf5 .tfm .txt .mat), which SimpleITK reads and writes.

Frame. ITK's points are in LPS, as here. Its transforms map a point of the output (the deformed
space) to its source in the input: they are backward maps.

Order. ITK's composite applies its last transform to a point first. A chain applies its first
transform to the material first, so its backward map applies the last one to a point first. Both
lists have the same order.

Outside of its grid a displacement field is 0, in ITK and here.
"""

from __future__ import annotations

import contextlib
import re

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.transforms.affine import Affine
from vtk_mls.transforms.chain import Chain
from vtk_mls.transforms.field import Field

_SEVERAL = "more than one transform"  # in a warning of SimpleITK, which takes the first
_NO_FILE = ("Could not create Transform IO", "failed to read file", "Tags must be delimited")


def read(path):
    """Read a transform.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Affine, Field or Chain

    Raises
    ------
    ValueError
        Also for transforms of another type, such as B-splines.
    """
    sitk = _simpleitk()
    with _warnings(sitk) as warnings:
        try:
            transform = sitk.ReadTransform(str(path))
        except RuntimeError as error:
            raise ValueError(_reason(str(error))) from None
    if any(_SEVERAL in text for text in warnings):
        raise ValueError("it holds several transforms that are not a composite; write them as one")
    if transform.GetDimension() != 3:
        raise ValueError(f"its transform must have 3 dimensions, got {transform.GetDimension()}")
    parts = _parts(transform)
    return parts[0] if len(parts) == 1 else Chain(parts)


def _parts(transform):
    """The transforms (Affine, Field) of SimpleITK's transform, in its order."""
    if transform.IsLinear():
        return [_affine(transform)]
    transform = transform.Downcast()
    name = transform.GetName()
    if name == "DisplacementFieldTransform":
        return [_field(transform.GetDisplacementField())]
    if name == "CompositeTransform":
        count = transform.GetNumberOfTransforms()
        members = [transform.GetNthTransform(i).Downcast() for i in range(count)]
        # SimpleITK packs what it does not know into a composite, again and again
        if all(member.GetName() != name or member.IsLinear() for member in members):
            return [part for member in members for part in _parts(member)]
    raise ValueError(
        f"its {name} is neither linear nor a displacement field; SimpleITK's "
        "TransformToDisplacementField makes one of it"
    )


def _affine(transform):
    """The Affine of a linear transform."""
    zero, axes, backward = (0.0, 0.0, 0.0), np.eye(3).tolist(), np.eye(4)
    backward[:3, :3] = np.transpose([transform.TransformVector(axis, zero) for axis in axes])
    backward[:3, 3] = transform.TransformPoint(zero)
    if not np.isfinite(backward).all() or np.linalg.matrix_rank(backward[:3, :3]) < 3:
        raise ValueError(f"its matrix must be invertible, got {backward[:3, :3].tolist()}")
    return Affine(_inverse(backward))


def _inverse(matrix):
    """The inverse of a matrix (4, 4) whose last row is (0, 0, 0, 1)."""
    inverse = np.linalg.inv(matrix)
    inverse[3] = 0, 0, 0, 1
    return inverse


def _field(image):
    """The Field of an image of displacements."""
    grid = Grid(
        image.GetSize(),
        image.GetOrigin(),
        image.GetSpacing(),
        np.reshape(image.GetDirection(), (3, 3)),
    )
    return Field(_simpleitk().GetArrayFromImage(image), grid)


def _simpleitk():
    try:
        import SimpleITK
    except ImportError:
        raise ValueError(
            "ITK's transform files need the package SimpleITK: pip install SimpleITK"
        ) from None
    return SimpleITK


@contextlib.contextmanager
def _warnings(sitk):
    """The list of the warnings that ITK gives in the block, in place of printing them."""
    texts = []

    class Logger(sitk.LoggerBase):
        def DisplayText(self, text):
            texts.append(text)

        DisplayWarningText = DisplayErrorText = DisplayText
        DisplayGenericOutputText = DisplayDebugText = DisplayText

    logger = Logger()
    usual = logger.SetAsGlobalITKLogger()
    try:
        yield texts
    finally:
        usual.SetAsGlobalITKLogger()


def _reason(text):
    """The reason in an exception of SimpleITK."""
    if any(part in text for part in _NO_FILE):
        return "it is no transform file of ITK"
    found = re.search(r"ITK ERROR: \w+\(0x[0-9a-f]+\): (.*)", text)
    reason = found[1] if found else text.splitlines()[-1]
    return f"ITK says: {' '.join(reason.split())}"
