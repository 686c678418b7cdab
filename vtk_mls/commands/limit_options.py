"""Options that say where a deformation acts: masks and faces."""

from __future__ import annotations

from vtk_mls.commands import property_options
from vtk_mls.commands.running import read

_BALL, _IMAGE, _FIXED, _SLIDING = "--mask-ball", "--mask", "--fixed-plane", "--sliding-plane"


def add(parser):
    """Add the options to a parser."""
    from vtk_mls.filters import property_tables as tables

    property_options.add(parser, tables.MASK_BALL, flag=_BALL)
    property_options.add(
        parser,
        tables.MASK,
        flag=_IMAGE,
        text="image in the deformed space by which displacements are multiplied, from 0 to 1; of "
        "integers, as of labels, what is not 0 counts as 1; outside of it nothing moves",
    )
    property_options.add(parser, tables.FIXED_PLANES, flag=_FIXED, more="may be repeated")
    property_options.add(parser, tables.SLIDING_PLANES, flag=_SLIDING, more="may be repeated")


def apply(options, algorithm):
    """Set the mask and the faces of a filter."""
    mask, faces = limits(options)
    algorithm.SetMask(mask)
    for face in faces:
        algorithm.AddConstraint(face)


def limits(options):
    """The mask, or None, and the faces, a list.

    Raises
    ------
    OSError, ValueError
        Naming the option or the file.
    """
    from vtk_mls import FixedFace, SlidingFace
    from vtk_mls.filters import limit_inputs

    masks, faces = [], []
    if options.mask_ball is not None:
        numbers = _numbers(_BALL, options.mask_ball, 5)
        masks.append(limit_inputs.ball_mask(numbers, f"`{_BALL}`"))
    if options.mask is not None:
        masks.append(_image_mask(options.mask))
    if len(masks) > 1:
        raise ValueError(
            f"a deformation has one mask, got `{_BALL}` and `{_IMAGE}`; multiply them to one image"
        )
    for flag, texts, kind in (
        (_FIXED, options.fixed_planes, FixedFace),
        (_SLIDING, options.sliding_planes, SlidingFace),
    ):
        for text in texts:
            faces.append(limit_inputs.face(kind, _numbers(flag, text, 7), f"`{flag}`"))
    return masks[0] if masks else None, faces


def _image_mask(path):
    from vtk_mls import io
    from vtk_mls.filters import limit_inputs

    image = read(io.read_dataset, path)
    if not image.IsA("vtkImageData"):
        raise ValueError(f"`{_IMAGE}` must be an image, got a {image.GetClassName()} in `{path}`")
    return limit_inputs.image_mask(image, f"`{path}`")


def _numbers(flag, text, count):
    """Numbers from the text of an option."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise ValueError(f"`{flag}` must be {count} numbers with commas, got `{text:.60}`")
    return values
