"""ITK's transform files (.h5 .hdf5 .tfm .txt .mat), which SimpleITK reads and writes.

Text with matrices alone, such as the linear transforms of 3D Slicer, is read without SimpleITK.

Frame. ITK's points are in LPS, as here. Its transforms map a point of the output (the deformed
space) to its source in the input: they are backward maps.

Order. ITK's composite applies its last transform to a point first. A chain applies its first
transform to the material first, so its backward map applies the last one to a point first. Both
lists have the same order.

Outside of its grid a displacement field is 0, in ITK and here. A map on a grid is written as its
best affine transform and the rest of its displacements, so that it goes on affinely outside.

Composites. In HDF5 a single transform is written as a composite, because nitransforms skips all
others. In text it is written alone, because nitransforms reads no composites there.
"""

import contextlib
import errno
import importlib.util
import os
import re
from functools import reduce

import numpy as np

from vtk_mls.base.errors import InputError
from vtk_mls.base.grid import Grid
from vtk_mls.base.linear_algebra import fitted_affine, transformed
from vtk_mls.transforms.affine import Affine
from vtk_mls.transforms.chain import Chain
from vtk_mls.transforms.field import Field
from vtk_mls.vtk.objects import configured

_HDF5, _TEXT = (".h5", ".hdf5"), (".tfm", ".txt")
_NAME = re.compile(r"^Transform: (\w+?)_(?:double|float)_3_3\s*$", re.M)
_NUMBERS = re.compile(r"^(?:Fixed)?Parameters:([-+.eE\d\s]*?)$", re.M)
_MATRICES = {"AffineTransform", "MatrixOffsetTransformBase"}  # a matrix, a translation; a center
_MAX_LAST_LINE = 4096  # bytes
_MAX_CONDITION = 1e4  # of an affine part
_MAX_FITTED = 64  # points along an axis to which it is fitted
_SEVERAL = "more than one transform"  # in a warning of SimpleITK, which takes the first
_NO_FILE = ("Could not create Transform IO", "failed to read file", "Tags must be delimited")


def read(path):
    """The Affine, Field or Chain of a file.

    Transforms of another type, such as B-splines, are a ValueError.
    """
    import SimpleITK as sitk

    with _warnings() as warnings:
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


def read_text(path):
    """As `read`; only a file with other transforms than matrices needs SimpleITK."""
    text = path.read_text(encoding="latin-1")
    names = _NAME.findall(text)
    members = names[names[:1] == ["CompositeTransform"] :]
    numbers = [np.array(line.split(), float) for line in _NUMBERS.findall(text)]
    sizes, is_known = [row.size for row in numbers], {*members} <= _MATRICES
    if is_known and sizes == [12, 3] * len(members) and (len(members) == 1 or members != names):
        return _affine(reduce(np.matmul, map(_matrix, numbers[::2], numbers[1::2]), np.eye(4)))
    if importlib.util.find_spec("SimpleITK") is None:
        raise InputError(
            f"holds {', '.join(names) or 'no matrix'}, which needs the package SimpleITK: "
            "pip install SimpleITK"
        )
    return read(path)


def _matrix(parameters, center):
    """The backward matrix (4, 4) of a linear transform: its matrix and translation, row by row."""
    matrix, linear = np.eye(4), parameters[:9].reshape(3, 3)
    matrix[:3, :3], matrix[:3, 3] = linear, center + parameters[9:] - linear @ center
    return matrix


def _parts(transform):
    """The transforms (Affine, Field) of SimpleITK's transform, in its order."""
    if transform.IsLinear():
        zero, axes, backward = (0.0, 0.0, 0.0), np.eye(3).tolist(), np.eye(4)
        backward[:3, :3] = np.transpose([transform.TransformVector(axis, zero) for axis in axes])
        backward[:3, 3] = transform.TransformPoint(zero)
        return [_affine(backward)]
    transform = transform.Downcast()
    name = transform.GetName()
    if name == "DisplacementFieldTransform":
        return [_field(transform.GetDisplacementField())]
    if name == "CompositeTransform":
        count = transform.GetNumberOfTransforms()
        members = [transform.GetNthTransform(i).Downcast() for i in range(count)]
        # SimpleITK wraps a transform that it does not know in one composite after another
        if all(member.GetName() != name or member.IsLinear() for member in members):
            return [part for member in members for part in _parts(member)]
    raise ValueError(
        f"its {name} is neither linear nor a displacement field; SimpleITK's "
        "TransformToDisplacementField makes one of it"
    )


def _affine(backward):
    if not np.isfinite(backward).all() or np.linalg.matrix_rank(backward[:3, :3]) < 3:
        raise ValueError(f"its matrix must be invertible, got {backward[:3, :3].tolist()}")
    return Affine(_inverse(backward))


def _inverse(matrix):
    """The inverse of a matrix (4, 4) whose last row is (0, 0, 0, 1)."""
    inverse = np.linalg.inv(matrix)
    inverse[3] = 0, 0, 0, 1
    return inverse


def _field(image):
    import SimpleITK as sitk

    direction = np.reshape(image.GetDirection(), (3, 3))
    grid = Grid(image.GetSize(), image.GetOrigin(), image.GetSpacing(), direction)
    return Field(sitk.GetArrayFromImage(image), grid)


def write(transforms, path):
    """Write transforms (Affine and Field), applied first to last to the material.

    A .mat file holds one Affine.
    """
    import SimpleITK as sitk

    members = [_to_itk(transform) for transform in transforms]
    if len(members) > 1 or path.suffix.lower() in _HDF5:
        content = sitk.CompositeTransform(members)
    else:
        (content,) = members
    try:
        sitk.WriteTransform(content, str(path))
    except RuntimeError as error:
        raise OSError(_reason(str(error))) from None
    _check_complete(path)


def write_field(content, path):
    """Write a `FieldContent` as an affine transform and the rest of the field."""
    field = Field(content.displacement, content.grid)
    displacement, grid = field.displacement, field.grid
    inverse = _inverse(_best_affine(displacement, grid))
    rest = np.empty(displacement.shape, np.float32)
    for k, layer in enumerate(displacement):
        v = grid.points(k * layer[..., 0].size, (k + 1) * layer[..., 0].size)
        v_rest = transformed(inverse[:3, :3], v + layer.reshape(-1, 3)) + inverse[:3, 3] - v
        rest[k] = v_rest.reshape(layer.shape)
    write([Affine(inverse), Field(rest, grid)], path)


def _best_affine(displacement, grid):
    """(4, 4) matrix of the affine map nearest to v + d(v), by least squares over a grid."""
    axes = [np.arange(0, count, -(-count // _MAX_FITTED)) for count in grid.shape]
    ids = np.ravel_multi_index(np.ix_(*axes), grid.shape).ravel()
    v, matrix = grid.points_of(ids), np.eye(4)
    linear, offset = fitted_affine(v, v + displacement.reshape(-1, 3)[ids])
    if np.linalg.cond(linear) < _MAX_CONDITION:  # not flat
        matrix[:3, :3], matrix[:3, 3] = linear, offset
    return matrix


def _to_itk(transform):
    import SimpleITK as sitk

    if isinstance(transform, Affine):
        backward = _inverse(transform.matrix)
        matrix, translation = backward[:3, :3].ravel().tolist(), backward[:3, 3].tolist()
        return configured(sitk.AffineTransform(3), Matrix=matrix, Translation=translation)
    grid = transform.grid
    spacing = np.linalg.norm(grid.index_to_world, axis=0)
    image = sitk.GetImageFromArray(transform.displacement.astype(np.float64), isVector=True)
    direction = (grid.index_to_world / spacing).ravel().tolist()
    configured(image, Origin=grid.origin.tolist(), Spacing=spacing.tolist(), Direction=direction)
    return sitk.DisplacementFieldTransform(image)


def _check_complete(path):
    """Raise OSError if the end of a file is missing, which ITK does not notice on a full disk."""
    with path.open("rb") as file:
        file.seek(max(file.seek(0, os.SEEK_END) - _MAX_LAST_LINE, 0))
        end = file.read()
    is_text = path.suffix.lower() in _TEXT
    last = end.removesuffix(b"\n").rpartition(b"\n")[2]
    if not end or (is_text and not (end.endswith(b"\n") and last.startswith(b"FixedParameters:"))):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextlib.contextmanager
def _warnings():
    """The list of ITK's warnings in the block, which are not printed."""
    import SimpleITK as sitk

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
    if any(part in text for part in _NO_FILE):
        return "it is not an ITK transform file"
    match = re.search(r"ITK ERROR: \w+\(0x[0-9a-f]+\): (.*)", text)
    reason = match[1] if match else text.splitlines()[-1]
    return f"ITK says: {' '.join(reason.split())}"
