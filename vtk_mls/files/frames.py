"""Anatomical frames: which way x, y and z point in a patient.

The one world of this package is LPS, as of ITK and 3D Slicer's files: x to the patient's left, y to
the back (posterior), z to the head (superior). NIfTI and FreeSurfer have RAS. A frame is named by
its three letters or, as in NRRD, by three words.
"""

from __future__ import annotations

import numpy as np

_SIGNS = ({"L": 1.0, "R": -1.0}, {"P": 1.0, "A": -1.0}, {"S": 1.0, "I": -1.0})


def signs(frame):
    """Factors (3,) between coordinates in a frame and those in LPS, the same both ways.

    Parameters
    ----------
    frame : str
        Such as "RAS" or "right-anterior-superior", in letters of any case.

    Raises
    ------
    ValueError
        If it is none whose axes run along those of LPS, in their order.
    """
    words = str(frame).strip().upper().split("-")
    letters = "".join(word[:1] for word in words) if len(words) == 3 else words[0]
    try:
        return np.array([of[letter] for of, letter in zip(_SIGNS, letters, strict=True)])
    except (KeyError, ValueError):
        raise ValueError(f"must be LPS, RAS or another such frame, got `{frame!s:.40}`") from None
