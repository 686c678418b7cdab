"""Notes on possible mistakes that a command adds to its summary."""

import sys
from pathlib import Path

import numpy as np

from vtk_mls import io
from vtk_mls.files.block_files import blocks
from vtk_mls.files.ome_zarr import SUFFIX
from vtk_mls.filters import initial_transforms
from vtk_mls.queries.arrival import arrives, coarse, has_material
from vtk_mls.queries.certificate import certificate_of_inverse
from vtk_mls.queries.fields import DisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_COUNTS = ("InvertedCells", "UncheckedCells", "LargestBlend")
_DETERMINANT = "JacobianDeterminant"
# Other arrays that the filter gives points and cells of a mesh, beside those of its quality.
_UNASKED = "ForwardDisplacement", "NoInverse", "Void", "vtkGhostType", "Jacobian", _DETERMINANT


def notes(algorithm):
    """Notes on possible mistakes of an MLSDeform, for the end of a sentence."""
    deformation = algorithm.updated_deformation()
    found = (folds(deformation, target, source) for source, target in _images(algorithm))
    return next(filter(None, found), "") + _far(algorithm)


def field_notes(algorithm, is_whole=True, proof=None):
    """The same of an MLSDisplacementField: of a whole field its certificate, `proof` if known."""
    deformation, is_inverse = algorithm.updated_deformation(), algorithm.GetInverse()
    note = _far(algorithm, is_moved=not is_inverse)
    grid = arrays.ImageGeometry.of_image(algorithm.GetOutput()).grid
    is_flat = min(grid.dimensions) == 1
    if algorithm.GetGenerateJacobianDeterminant() or (is_inverse and (is_flat or deformation.cuts)):
        return note  # these count folds themselves
    if not is_whole or is_flat:
        return folds(deformation, grid) + note
    return f"; interpolated linearly, {proof or certificate(algorithm, grid)}{note}"


def certificate(algorithm, grid):
    """The certificate of the output of an MLSDisplacementField, which is on `grid`."""
    deformation, data = algorithm.updated_deformation(), algorithm.GetOutput().GetPointData()
    displacement = arrays.to_numpy(data.GetScalars()).reshape(*grid.shape, 3)
    if algorithm.GetInverse():
        return certificate_of_inverse(deformation, DisplacementField(displacement, grid))
    distance = data.GetArray("VoidDistance")
    distance = None if distance is None else arrays.to_numpy(distance).reshape(grid.shape)
    return deformation.certificate(DisplacementField(displacement, grid, distance))


def warn(path, sentence):
    """Print a warning about an output."""
    print(f"vtk-mls: `{path}`: {sentence}", file=sys.stderr)


def is_empty(algorithm):
    """Whether the output images contain no material of the input."""
    if algorithm.has_reference():  # the filter itself warns
        return False
    pairs = _images(algorithm)
    is_complete = len(pairs) == len(blocks(algorithm.GetOutput()))
    deformation = algorithm.updated_deformation()
    return bool(pairs) and is_complete and not any(arrives(deformation, *pair) for pair in pairs)


def warn_of_emptiness(are_empty, options):
    """Print a warning about outputs for which `is_empty` is true: one for each time step, or the
    one output.
    """
    if not any(are_empty):
        return
    part = "" if all(are_empty) else f"{sum(are_empty)} of {len(are_empty)} time steps of "
    can_fit = options.output_grid == "input" and not options.output.lower().endswith(SUFFIX)
    advice = "; --grid fitted puts the output where it goes" * can_fit
    sentence = f"nothing of `{options.input}` is in {part}the output, for the control points move "
    warn(options.output, f"{sentence}it elsewhere{advice}")


def folds(deformation, target, source=None):
    """A note, for the end of a sentence, if a map folds at points of the grid `target` whose
    material comes from the grid `source`, if there is one.
    """
    grid = coarse(target)
    is_material = has_material(deformation, grid, source)
    jacobian = deformation.jacobian_field(grid).reshape(-1, 3, 3)
    is_folded = is_material & (np.linalg.det(jacobian.astype(float)) <= 0)
    count, total = int(is_folded.sum()), int(is_material.sum())
    if count == 0:
        return ""
    return f"; the map folds at {count} of {total} sampled points ({count / total:.2%})"


def background(used):
    """A note on automatic backgrounds other than 0, for the end of a sentence; "" without any.

    `used` are (name of an array, number or tuple of numbers).
    """
    names = {}
    for name, value in sorted(used, key=str):
        numbers = np.atleast_1d(value).tolist()
        if any(numbers):
            names.setdefault(", ".join(f"{number:.6g}" for number in numbers), name)
    parts = [f"({text}) of `{name}`" for text, name in names.items()] if len(names) > 1 else names
    return f"; background {' and '.join(parts)}, the median of the corners" if names else ""


def void(image):
    """The number of void points of an image with the array Void, for the end of a sentence."""
    return f"; void: {number_of(image, 'Void')}" if image.GetPointData().HasArray("Void") else ""


def number_of(image, name):
    """The number of points of an image where a mask array is set."""
    mask = image.GetPointData().GetArray(name)
    return 0 if mask is None else int(arrays.to_numpy(mask).astype(bool).sum())


class InvertedCells:
    """Counts cells that an MLSDeform inverts in one or more runs; outputs show no trace."""

    def __init__(self, deform):
        self._deform, self._is_counted = deform, False
        self._count, self._largest_blends = 0, []

    def prepare(self, dataset):
        """Before the filter runs on a vtkDataObject.

        Cells of images are not counted, because it takes long. Neither are cells of a mesh that
        already has the arrays of the filter.
        """
        self._is_counted = all(_can_count(block) for block in blocks(dataset))
        self._deform.SetGenerateJacobianDeterminant(self._is_counted)
        self._deform.SetGenerateLargestBlend(self._is_counted)

    def take(self):
        """Count the output's cells, and remove the filter's arrays from it."""
        if not self._is_counted:
            return
        for block in blocks(self._deform.GetOutput()):
            field = block.GetFieldData()
            inverted, _, largest_blend = map(field.GetArray, _COUNTS)
            if inverted is not None and inverted.GetValue(0) > 0:
                self._count += int(inverted.GetValue(0))
                self._largest_blends.append(largest_blend.GetValue(0))
            block.GetPointData().RemoveArray(_DETERMINANT)
            for name in _COUNTS:
                field.RemoveArray(name)

    def note(self):
        """The number of inverted cells and the remedy, for the end of a sentence."""
        if self._count == 0:
            return ""
        text = f"; {self._count} cell{'s' * (self._count != 1)} inside out"
        blend = min(self._largest_blends, key=abs)
        return text + f" (at most --blend {blend:g} inverts no cell)" * (blend != 0)


def dropped_arrays(output, path):
    """The names of input arrays that a file cannot hold, for the end of a sentence."""
    names = [f"`{name}`" for name in io.left_out(output, path) if name not in _UNASKED]
    if not names:
        return ""
    return f"; without {', '.join(names)}, which {Path(path).suffix} cannot hold"


def _images(algorithm):
    """Pairs (input, output) of the grids of images, also of blocks."""
    sources, targets = blocks(algorithm.GetInputDataObject(0, 0)), blocks(algorithm.GetOutput())
    return [
        tuple(ImageGeometry.of_image(image).grid for image in pair)
        for pair in zip(sources, targets)
        if all(image.IsA("vtkImageData") for image in pair)
    ]


def _far(algorithm, is_moved=False):
    """A note, for the end of a sentence, if all p, or with `is_moved` all q, are far from the data:
    by half of the longest side of their bounds.
    """
    data, handles = (algorithm.GetInputDataObject(port, 0) for port in (0, 1))
    points = arrays.to_numpy(handles.GetPoints().GetData())
    initial, _ = initial_transforms.split_chain(algorithm.updated_deformation())
    if is_moved:
        displacement = arrays.to_numpy(handles.GetPointData().GetArray("Displacement"))
        points = points + algorithm.GetBlend() * displacement
    elif initial is not None:
        points = initial.backward(points)  # where the data are
    bounds = [np.reshape(block.GetBounds(), (3, 2)) for block in blocks(data)]
    low, high = np.min(bounds, axis=0)[:, 0], np.max(bounds, axis=0)[:, 1]
    margin = (high - low).max() / 2
    if ((points >= low - margin) & (points <= high + margin)).all(axis=1).any():
        return ""
    side = "moved (q)" if is_moved else "at rest (p)"
    return (
        f"; all control points, {side}, are far from the data: is their frame right "
        "(--handles-space)?"
    )


def _can_count(dataset):
    return not (
        dataset.IsA("vtkImageData")
        or dataset.GetPointData().HasArray(_DETERMINANT)
        or any(dataset.GetFieldData().HasArray(name) for name in _COUNTS)
    )
