"""Options that say where a deformation acts: masks and faces."""

from __future__ import annotations

from vtk_mls.commands import property_options
from vtk_mls.commands.running import read_image

_BALL, _IMAGE, _FIXED, _SLIDING = "--mask-ball", "--mask", "--fixed-plane", "--sliding-plane"


def add(parser, is_interactive=False):
    """Add the options to a parser; interactive commands have the ball only."""
    from vtk_mls.filters import property_tables as tables

    property_options.add(parser, tables.MASK_BALL, flag=_BALL)
    if is_interactive:
        return
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
    """The mask, or None, and the faces, a list. Errors name the option or the file."""
    from vtk_mls import FixedFace, SlidingFace
    from vtk_mls.filters import limit_inputs

    mask = ball(options)
    if options.mask is not None:
        image = read_image(_IMAGE, options.mask)
        if mask is not None:
            raise ValueError(
                f"a deformation has one mask, got `{_BALL}` and `{_IMAGE}`; multiply them to one "
                "image"
            )
        mask = limit_inputs.image_mask(image, f"`{options.mask}`")
    planes = (
        (_FIXED, options.fixed_planes, FixedFace),
        (_SLIDING, options.sliding_planes, SlidingFace),
    )
    faces = [
        limit_inputs.face(kind, property_options.numbers(flag, text, 7), f"`{flag}`")
        for flag, texts, kind in planes
        for text in texts
    ]
    return mask, faces


def ball(options):
    """The BallMask of the option, or None; a ValueError names the option."""
    from vtk_mls.filters import limit_inputs

    if options.mask_ball is None:
        return None
    ball_values = property_options.numbers(_BALL, options.mask_ball, 5)
    return limit_inputs.ball_mask(ball_values, f"`{_BALL}`")
