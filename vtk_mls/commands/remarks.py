"""What a command says of a map beside its result: what may not have been meant."""

from __future__ import annotations

import sys

from vtk_mls.commands import property_options

MAX_SAMPLES = 32  # along each axis of a grid on which maps are sampled


def remark(algorithm, is_field=False):
    """What is to be said of a map that a filter has computed, for the end of a sentence."""
    from vtk_mls.vtk import arrays

    handles = algorithm.GetInputDataObject(1, 0)
    displacement = handles.GetPointData().GetArray("Displacement")
    if not (algorithm.GetBlend() and arrays.to_numpy(displacement).any()):
        return "; nothing moves, for all control points rest"
    far = _far(algorithm, is_field)
    if far:
        return f"; {far}: is their frame right (--handles-space)?"
    has_degree = algorithm.GetDegree() != property_options.value("Degree")
    if has_degree and algorithm.GetKind() != "polynomial":
        return "; the degree is that of polynomials, and counts for nothing here"
    return ""


def warn(path, sentence):
    """Say something of an output that is not as it should be."""
    print(f"vtk-mls: `{path}`: {sentence}", file=sys.stderr)


def is_empty(algorithm):
    """Whether nothing of the input is in an output of images."""
    from vtk_mls.files.blocks import blocks

    pairs = _images(algorithm)
    is_complete = len(pairs) == len(blocks(algorithm.GetOutput()))
    deformation = algorithm.updated_deformation()
    return bool(pairs) and is_complete and not any(_arrives(deformation, *pair) for pair in pairs)


def emptiness(are_empty, options):
    """A sentence about outputs for which `is_empty` holds; "" if it does for none.

    Parameters
    ----------
    are_empty : list of bool
        Of each time step, or of the one output.
    options : argparse.Namespace
    """
    if not any(are_empty):
        return ""
    part = "" if all(are_empty) else f"{sum(are_empty)} of {len(are_empty)} time steps of "
    advice = "; --grid fitted puts the output where it goes" * (options.output_grid == "input")
    return (
        f"nothing of `{options.input}` is in {part}the output, for the control points move it "
        f"elsewhere{advice}"
    )


def whereabouts(algorithm):
    """For the end of a sentence, whether an output of images is not where its input is."""
    pairs = _images(algorithm)
    is_apart = bool(pairs) and all(_are_apart(*grids) for grids in pairs)
    return "; the output lies apart from the input" * is_apart


def folds(deformation, target, source=None):
    """For the end of a sentence, whether a map folds at some points of a grid.

    Parameters
    ----------
    deformation : Deformation
    target : Grid
    source : Grid, optional
        Only points whose material comes from it count.
    """
    import numpy as np

    grid = _coarse(target)
    counts = _is_material(deformation, grid, source)
    jacobian = deformation.jacobian_field(grid).reshape(-1, 3, 3)
    is_folded = counts & (np.linalg.det(jacobian.astype(float)) <= 0)
    count, total = int(is_folded.sum()), int(counts.sum())
    if count == 0:
        return ""
    return f"; the map folds at {count} of {total} sampled points ({count / total:.2%})"


def folds_of_images(algorithm):
    """`folds` of the outputs of a filter that are images, the first that has some."""
    deformation = algorithm.updated_deformation()
    found = (folds(deformation, target, source) for source, target in _images(algorithm))
    return next(filter(None, found), "")


def _images(algorithm):
    """The grids of images, alone or as blocks: (input, output) of each."""
    from vtk_mls.files.blocks import blocks
    from vtk_mls.vtk.arrays import ImageGeometry

    sources, targets = blocks(algorithm.GetInputDataObject(0, 0)), blocks(algorithm.GetOutput())
    return [
        tuple(ImageGeometry.of_image(image).grid for image in pair)
        for pair in zip(sources, targets)
        if all(image.IsA("vtkImageData") for image in pair)
    ]


def _coarse(grid):
    """A grid with the corners of another, and few points."""
    import numpy as np

    from vtk_mls import Grid

    full = np.array(grid.dimensions)
    dimensions = np.minimum(full, MAX_SAMPLES)
    spacing = grid.spacing * (np.maximum(full - 1, 1) / np.maximum(dimensions - 1, 1))
    return Grid(dimensions, grid.origin, spacing, grid.direction)


def _is_material(deformation, grid, source):
    """Which points of a grid have material, that of `source` if it is given: (n,) bool."""
    import numpy as np

    points = grid.points()
    if source is None:
        found = np.ones(len(points), bool)
    else:
        found = source.covers(source.index_of(deformation.backward(points)))
    return found & ~deformation.void(points) if deformation.cuts else found


def _arrives(deformation, source, target):
    """Whether material of a grid is at points of another, first looked for at some of these."""
    import numpy as np

    from vtk_mls import Sampling

    if _is_material(deformation, _coarse(target), source).any():
        return True
    mask = np.ones(source.shape, np.uint8)
    return bool(deformation.resample([mask], Sampling(source, target, "nearest"))[0].any())


def _are_apart(source, target):
    """Whether the boxes around two grids do not meet."""
    low, high = zip(
        *((grid.corners().min(axis=0), grid.corners().max(axis=0)) for grid in (source, target))
    )
    return bool((low[0] > high[1]).any() or (low[1] > high[0]).any())


def _far(algorithm, is_field):
    """Which control points are far from what they should be near; "" for none.

    The data are where p is. Fields and output grids are where q is, but for fields of the inverse.
    """
    from vtk_mls.files.blocks import blocks
    from vtk_mls.vtk import arrays

    dataset, handles = (algorithm.GetInputDataObject(port, 0) for port in (0, 1))
    rest = arrays.to_numpy(handles.GetPoints().GetData())
    displacement = arrays.to_numpy(handles.GetPointData().GetArray("Displacement"))
    deformed = rest + algorithm.GetBlend() * displacement
    if is_field:
        points, side = (rest, "at rest (p)") if algorithm.GetInverse() else (deformed, "moved (q)")
        is_far = _are_far_away(points, blocks(dataset))
        return f"all control points, {side}, are far from the data, where the field is" * is_far
    if _are_far_away(rest, blocks(dataset)):
        return "all control points, at rest (p), are far from the data"
    images = [block for block in blocks(algorithm.GetOutput()) if block.IsA("vtkImageData")]
    is_far = _are_far_away(deformed, images)
    return "all control points, moved (q), are far from the grid of the output" * is_far


def _are_far_away(points, datasets):
    """Whether none is in the bounds of datasets, enlarged by half of their longest side."""
    import numpy as np

    bounds = [np.reshape(dataset.GetBounds(), (3, 2)) for dataset in datasets]
    bounds = [box for box in bounds if (box[:, 0] <= box[:, 1]).all()]
    if not bounds or len(points) == 0:
        return False
    low, high = np.min(bounds, axis=0)[:, 0], np.max(bounds, axis=0)[:, 1]
    margin = (high - low).max() / 2
    return not ((points >= low - margin) & (points <= high + margin)).all(axis=1).any()
