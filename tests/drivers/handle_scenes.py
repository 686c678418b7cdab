"""Small deformations by curves, rigid regions, masks and faces, without VTK."""

from __future__ import annotations

import numpy as np

from vtk_mls import (
    BallMask,
    Capsule,
    CurveHandle,
    Deformation,
    FixedFace,
    Grid,
    HalfPlane,
    ImageMask,
    Labels,
    Plane,
    RegionHandle,
    SlidingFace,
    Surface,
)
from vtk_mls.model.handles.distance_image import DistanceImage

CENTER = np.array([20.0, 20, 20])
IMAGE_GRID = Grid((11, 11, 11), CENTER - 15, (3.0, 3.0, 3.0))
HALF_PLANE = HalfPlane(CENTER, (0.1, 0.2, 1), (1, 0.1, 0))


def scenes(rest, deformed):
    """Deformations by their names, with control points `rest` and `deformed` (n, 3) in a box."""
    nodes = np.array([(5, 5, 30), (15, 8, 33), (30, 6, 30)])
    curve = CurveHandle(nodes, nodes + [(0, 1, 0), (-1, 3, 1), (1, 1, 1)])
    regions = [
        RegionHandle(Capsule((30, 30, 10), (34, 26, 14), 3), _turn(0.2, (0, 1, 1))),
        RegionHandle(_ball_of_labels(), _turn(-0.2, (1, 0, -1))),
    ]
    masks = BallMask(CENTER, 14, 8), ImageMask(_bump(), IMAGE_GRID)
    plane, face = Plane((14, 0, 0), (1, 0, 0.1)), _curved_face()
    shapes = {"handles": [curve, *regions], "smoothing": 3.0}
    limits = {"mask": masks[0], "constraints": [FixedFace(plane, 8)]}
    other_limits = {"mask": masks[1], "constraints": [SlidingFace(plane, 8), face]}
    options = {
        "affine, curves": {"handles": [curve], "alpha": 1},
        "affine, regions and limits": {"handles": regions, **limits},
        "rigid, shapes": shapes,
        "rigid, shapes and other limits": {**shapes, **other_limits},
        "rigid, shapes and half-plane": {**shapes, "cuts": [HALF_PLANE]},
        "similarity, shapes and limits": {**shapes, **limits},
        "polynomial, shapes and other limits": {**shapes, **other_limits},
        "polynomial, degree 3, curves": {"handles": [curve], "degree": 3, "alpha": 1},
    }
    return {
        name: Deformation(rest, deformed, name.partition(",")[0], device="reference", **values)
        for name, values in options.items()
    }


def _turn(angle, shift):
    """A rotation about the axis through `CENTER` along z, and a shift: (4, 4)."""
    motion = np.eye(4)
    motion[:2, :2] = [(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))]
    motion[:3, 3] = CENTER + shift - motion[:3, :3] @ CENTER
    return motion


def _offsets(center):
    """Vectors (nz, ny, nx, 3) from a center to the points of `IMAGE_GRID`."""
    return (IMAGE_GRID.points() - center).reshape(*IMAGE_GRID.shape, 3)


def _ball_of_labels():
    """Labels whose image of distances is known: that of a ball."""
    distance = np.linalg.norm(_offsets((12, 26, 22)), axis=-1) - 4
    labels = Labels(distance < 0, IMAGE_GRID)
    vars(labels)["image"] = DistanceImage(IMAGE_GRID, distance.astype(np.float32))
    return labels


def _bump():
    """Values (nz, ny, nx) of a mask."""
    return np.exp(-((np.linalg.norm(_offsets(CENTER), axis=-1) / 14) ** 4))


def _curved_face():
    """A sliding face whose image of distances is known: that of a sphere."""
    offsets = _offsets((20, 20, -10))
    distance = np.linalg.norm(offsets, axis=-1)
    normals = np.moveaxis(offsets / distance[..., None], -1, 0)
    images = np.concatenate([np.abs(distance - 20)[None], normals]).astype(np.float32)
    face = SlidingFace(Surface.polygon([(8, 9, 10), (33, 10, 10), (31, 32, 10), (9, 30, 10)]), 8)
    vars(face)["_images"] = images, IMAGE_GRID
    return face
