"""Arrays on a grid, resampled through a deformation, and their gradients at the faces of voids.

Where the material ends, the array has a step from its value to the background. In the undeformed
material this step is one voxel wide along the cut, and its gradient is covariant (Eq. 29). Up to
half a voxel from the face it replaces the gradient of the values; over the next voxel both are
blended linearly. A closed cut has no step: half a voxel behind the face there must be a void.
"""

from dataclasses import replace

import numpy as np

from vtk_mls.base import buffer_pool, validation
from vtk_mls.base.linear_algebra import unit
from vtk_mls.base.validation import short_repr

# Distance from the face of a void up to which it affects the gradient, in voxels of the source.
_REACH = 1.5
_ON_FACE = 1e-3  # distance below which material counts as on a cut, in voxels


def checked_arrays(arrays, sampling):
    """The argument `arrays`: numbers at the points of the source grid."""
    arrays = list(arrays)
    for array in arrays:
        validation.check_unmasked("arrays", array)
    arrays = [np.asarray(array) for array in arrays]
    for array in arrays:
        check_values("arrays", array, sampling.source)
    return arrays


def check_values(name, array, grid):
    """Raise an error unless an argument holds numbers at the points of a grid."""
    shape, dtype = tuple(array.shape), np.dtype(array.dtype)
    if len(shape) not in (3, 4) or shape[:3] != grid.shape or 0 in shape:
        raise ValueError(
            f"`{name}` must have the shape of the grid, {grid.shape} or "
            f"{(*grid.shape, 'components')}, got {shape}"
        )
    if dtype.kind not in "iuf" or dtype.itemsize > 8:
        raise TypeError(f"`{name}` must hold integers or floats, got {dtype}")


def checked_scalars(array, grid):
    """The argument `array`: a real number at each point of a grid."""
    validation.check_unmasked("array", array)
    array = np.asarray(array)
    if array.dtype.kind not in "biuf" or array.shape != grid.shape:
        raise ValueError(
            f"`array` must be real numbers with the shape of the grid, {grid.shape}, "
            f"got {short_repr(array)}"
        )
    return array


def checked_vectors(vectors, grid):
    """The argument `vectors`: three numbers at each point of a grid, float32."""
    vectors = validation.single_precision("vectors", vectors)
    if vectors.shape != (*grid.shape, 3):
        raise ValueError(
            f"`vectors` must have the shape of the grid, {(*grid.shape, 3)}, got {vectors.shape}"
        )
    return vectors


def warn_of_background(arrays, sampling):
    """Warn of arrays whose types cannot hold the background."""
    sampling.warn_of_background({f"array {i}": array.dtype for i, array in enumerate(arrays)})


def distance_buffer(deformation, void_distance, target, is_needed=False):
    """The argument `void_distance` to be filled, or a buffer: (target.size,) float32.

    None if it is not given, unless `is_needed` and there are cuts.
    """
    if void_distance is None:
        is_needed &= bool(deformation.cuts)
        return buffer_pool.empty(target.size, np.float32) if is_needed else None
    validation.output_array("void_distance", void_distance, target.shape, np.float32)
    if not deformation.cuts:
        void_distance.fill(np.inf)
    return void_distance.reshape(-1)


def resampled(engine, deformation, arrays, sampling, progress, distances=None, covariant=None):
    """`arrays` resampled by an engine, in their own types.

    `distances` (target.size,) float32 are filled with void distances. `covariant` says whether
    vectors become unit vectors, by the index of each array of covariant vectors.
    """
    values = [validation.native_array(array) for array in arrays]
    results = engine.resample(deformation, values, sampling, progress, distances, covariant)
    return [new.astype(old.dtype, copy=False) for new, old in zip(results, arrays)]


def with_gradient(engine, deformation, arrays, sampling, normalise, progress, distances):
    """Resampled arrays, and the gradient of the last of `arrays`, which is not resampled itself.

    `distances` is a `distance_buffer` that is needed.
    """
    *arrays, array = arrays
    source, methods = sampling.source, sampling.methods(len(arrays) + 1)
    differencing, resampling, at_faces = progress.divided(1, 4, 2)
    slopes = engine.gradient(validation.native_array(array), source, differencing)
    *results, gradient = resampled(
        engine,
        deformation,
        [*arrays, slopes],
        sampling,
        resampling,
        distances,
        {len(arrays): normalise},
    )
    if deformation.cuts and not sampling.continues:
        # float32 if it holds all values of the type, else float64
        floats = validation.native_array(array)
        floats = floats.astype(np.promote_types(array.dtype, np.float32), copy=False)
        rows, values = gradients_near_faces(
            engine,
            deformation,
            distances,
            (floats, slopes),
            replace(
                sampling,
                interpolation=methods[-1],
                background=sampling.backgrounds(len(arrays) + 1)[-1],
            ),
            at_faces,
        )
        gradient.reshape(-1, 3)[rows] = unit(values) if normalise else values
    return results, gradient


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
