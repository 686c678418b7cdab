"""Anatomical frames: the directions of x, y and z in a patient.

World coordinates are LPS, as in ITK and in 3D Slicer's files: x points to the patient's left, y to
the back (posterior), z to the head (superior). NIfTI and FreeSurfer use RAS. A frame is named by
three letters or, as in NRRD, by three words.
"""

import numpy as np

_SIDES = ("right", "left"), ("anterior", "posterior"), ("inferior", "superior")  # from, to: LPS
_SIGNS = ({"L": 1.0, "R": -1.0}, {"P": 1.0, "A": -1.0}, {"S": 1.0, "I": -1.0})


def signs(frame):
    """Signs (3,) that convert coordinates between a frame and LPS, in both directions.

    `frame` is such as "RAS" or "right-anterior-superior", in any case. A ValueError says that its
    axes are not parallel to those of LPS, in the same order.
    """
    words = str(frame).strip().upper().split("-")
    letters = "".join(word[:1] for word in words) if len(words) == 3 else words[0]
    try:
        x, y, z = letters
        return np.array([of[letter] for of, letter in zip(_SIGNS, (x, y, z))])
    except (KeyError, ValueError):
        raise ValueError(f"must be LPS, RAS or another such frame, got `{frame!s:.40}`") from None


def direction(words):
    """The direction (3,) in LPS of an axis such as "left-to-right"; 0 for other words."""
    ends = tuple(words.strip().lower().split("-to-"))
    return np.array([float(ends == sides) - float(ends == sides[::-1]) for sides in _SIDES])
