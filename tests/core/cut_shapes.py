"""Cuts of all shapes for the tests of the core."""

import numpy as np
from control_point_sets import EVERYWHERE, KINDS_AND_DEGREES
from pairwise import paired

from vtk_mls import CUT_FRAMES, HalfPlane, Plane, Surface

HALF_PLANE = HalfPlane((128, 128, 128), (0.2, 0.1, 1), (1, 0.3, 0))
SHAPES = {
    "crossing half-planes": (HALF_PLANE, HalfPlane((128, 100, 128), (1, 0, 0.3), (0, 1, 0))),
    "half-plane": (HALF_PLANE,),
    "polygon": (Surface.polygon([(40, 40, 120), (200, 40, 130), (220, 200, 140), (30, 180, 130)]),),
    "plane": (Plane((128, 128, 128), (0.1, 0.2, 1)),),
    "concave polygon": (
        Surface.polygon([(40, 40, 128), (220, 40, 128), (128, 90, 128), (220, 220, 128)]),
    ),
    "bent surface": (
        Surface(
            [(60, 60, 100), (200, 60, 100), (60, 130, 140), (200, 130, 140), (130, 210, 110)],
            [(0, 1, 2), (1, 3, 2), (2, 3, 4)],
        ),
    ),
    "crossing planes": (Plane((128, 128, 128), (0.1, 0.2, 1)), Plane((100, 128, 100), (1, 0, 0.1))),
    "plane and half-plane": (Plane((128, 128, 100), (0.1, 0, 1)), HALF_PLANE),
    "outside": (HalfPlane((900, 128, 128), (0, 0, 1), (1, 0, 0)),),
}


EVERY_SHAPE = paired(
    shape=SHAPES,
    kind_and_degree=KINDS_AND_DEGREES,
    device=EVERYWHERE,
    cut_frame=CUT_FRAMES,
)


def lengths(vectors):
    return np.linalg.norm(vectors, axis=-1)


def are_apart(cuts, x, y):
    """Whether a cut lies between places x and y (m, 3)."""
    apart = np.zeros(len(x), bool)
    for cut in cuts:
        if isinstance(cut, Plane):
            apart |= (cut.height(x) < 0) != (cut.height(y) < 0)
        else:
            apart |= cut.blocks(x, y)
    return apart
