"""Gradients of a deformed array at the faces of voids.

Where the material ends, the array has a step from its value to the background. In the undeformed
material this step is one voxel wide along the cut, and its gradient is covariant (Eq. 29). Up to
half a voxel from the face it replaces the gradient of the values; over the next voxel both are
blended linearly. A closed cut has no step: half a voxel behind the face there must be a void.
"""

import numpy as np

# Distance from the face of a void up to which it affects the gradient, in voxels of the source.
_REACH = 1.5
_ON_FACE = 1e-3  # distance below which material counts as on a cut, in voxels


def gradients_near_faces(engine, deformation, void_distance, fields, sampling, progress):
    """Gradient of a deformed array near the faces of voids.

    `fields` are the undeformed array (nz, ny, nx) and its `vector_fields.gradient`; `void_distance`
    (target.size,) is in world units. Returns ids (m,) of points of the target, x fastest, and
    values (m, 3) per world unit.
    """
    values, slopes = fields
    source, voxel = sampling.source, np.abs(sampling.source.spacing).mean()
    (method,) = sampling.methods(1)
    rows = np.flatnonzero((void_distance >= 0) & (void_distance < _REACH * voxel))
    v = sampling.target.points_of(rows)
    mapping, differentiating, closing, interpolating = progress.divided(1, 3, 1, 1)
    origin = deformation.backward(v, mapping)
    transposed = deformation.jacobian(v, differentiating).swapaxes(1, 2)
    distance, away = deformation._nearest_face(v, origin)
    depth = _void_depth(deformation, v, (distance, away), transposed, voxel, closing)
    share = np.clip(_REACH - distance / voxel, 0, 1) * np.clip(4 * depth / voxel, 0, 1)

    interpolating.report(0)
    index, background = source.whole.index_of(origin), sampling.background
    step = (engine.sample(values, index, method, background, source) - background) / voxel
    inner = engine.sample(slopes, index, method, 0, source)
    blended = inner + share[:, None] * (step[:, None] * away - inner)
    return rows, np.einsum("mij,mj->mi", transposed, blended)


def nearest_face(deformation, v, origin):
    """Void distances (m,) at `v` (m, 3), and unit vectors (m, 3) away from the nearest cut.

    `origin` (m, 3) is G(v). The vectors are in its space.
    """
    positions = origin if deformation.in_rest_frame else v  # in the frame of the cuts
    distances = [cut.void_distance(positions, origin) for cut in deformation.cuts]
    nearest = np.argmin(distances, axis=0)
    away = np.zeros_like(v)
    for index, cut in enumerate(deformation.cuts):
        rows = nearest == index
        away[rows] = cut.away(positions[rows], origin[rows])
    return np.min(distances, axis=0), away


def _void_depth(deformation, v, face, transposed, voxel, progress):
    """Depth (m,) in the void of points half a voxel behind the face; `away` is corrected.

    Right on a cut in the rest frame the origin does not tell the side of the material: there, both
    sides are tried.
    """
    distance, away = face
    across = np.einsum("mij,mj->mi", transposed, away)
    squared = np.maximum(np.sum(across**2, axis=1), np.finfo(float).tiny)
    behind = v - ((distance + voxel / 2) / squared)[:, None] * across
    depth = -deformation.void_distance(behind, progress)
    unresolved = np.flatnonzero((distance < _ON_FACE * voxel) & (depth <= 0))
    if deformation.in_rest_frame and len(unresolved) > 0:
        mirrored = -deformation.void_distance(2 * v[unresolved] - behind[unresolved])
        rows = unresolved[mirrored > 0]
        away[rows], depth[rows] = -away[rows], mirrored[mirrored > 0]
    return depth
