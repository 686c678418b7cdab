"""The float64 specification of the map, in the order of the paper.

Equation numbers are those of Tejada et al., *Interactive Moving Least-Squares Volume Deformation*.
Points are rows here as there: l(x) = (x - q*) M + p*. No speed tricks: the engine is tested
against this module, and this module against the properties that the map must have. Both answer
the questions of `engine.protocol.Engine`.

Every sum is taken relative to the nearest control point, and weights relative to its weight.
In exact arithmetic that changes nothing; in floating point it keeps the digits where the weights
diverge.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vtk_mls import guesses, interpolation
from vtk_mls.control_points import ROTATION_KINDS
from vtk_mls.progress import SILENT

NAME = "reference (numpy, float64)"

# Squared distance, in squared local units, below which a point counts as on a control point.
_ON_CONTROL_POINT = 1e-32
# A weighted norm that lost this share of its square in the orthogonalisation is rounding.
_VANISHING = 1e-20
# The search for the inverse: evaluations; smallest share of a Newton step; residuals at which the
# iteration ends and at which the inverse counts as found, and distances from planes, local units.
_TRIALS, _SMALLEST_SHARE = 64, 0.01
_EXACT, _FOUND, _ON_PLANE = 1e-12, 1e-5, 1e-6
_SAMPLES = 1 << 12  # of the map, from which Newton's method starts again where it fails
_STARTS = 4  # so many of them, one after the other, ...
_WORTH = 0.05  # ... while they solve for at least this share of the remaining points
_CHUNK = 1 << 21  # numbers per temporary array


def backward(deformation, points, progress=SILENT):
    return points + _answers(deformation, points, "displacement", progress)


def jacobian(deformation, points, progress=SILENT):
    return _answers(deformation, points, "jacobian", progress)


def forward(deformation, points, progress=SILENT):
    displacement, found = np.full(points.shape, np.nan), np.zeros(len(points), bool)
    box = guesses.usual_bounds(points, guesses.bounds(points))
    for part in progress.over(_parts(len(points), deformation)):
        for region in deformation.regions:
            here = np.abs(region.control_points.local(points[part])).max(axis=1) <= guesses.FARTHEST
            here &= region.holds(deformation.planes, points[part])
            rows = part.start + np.flatnonzero(here)
            if len(rows) > 0:
                x = points[rows].astype(np.float64)
                v, residual = _inverse(deformation, region, x, box)
                close = _FOUND * _size_of(region.control_points, x)
                displacement[rows], found[rows] = v - x, residual <= close
    return displacement, found


def _inverse(deformation, region, x, box):
    """v with G(v) = x for x (m, 3); the residuals |G(v) - x| (m,), in world units.

    Newton's method starts from the map with p and q exchanged, and if that fails, from the samples
    of the map in the `box` (2, 3) whose images are nearest to x.
    """
    close = _FOUND * _size_of(region.control_points, x)
    exchanged = _Fit(deformation, region.exchanged.control_points, x)
    v, residual = _newton(deformation, region, x, x + exchanged.displacement())
    tried, samples = np.full(len(x), -1.0), None
    for _ in range(_STARTS):
        (lost,) = np.nonzero(residual > close)
        if len(lost) == 0:
            break
        samples = samples or _samples(deformation, region, box)
        start, tried[lost] = _nearest_sample(deformation, samples, x[lost], tried[lost])
        again, remaining = _newton(deformation, region, x[lost], start)
        better = remaining < residual[lost]
        v[lost[better]], residual[lost[better]] = again[better], remaining[better]
        if (remaining <= close[lost]).mean() < _WORTH:
            break
    return v, residual


def _newton(deformation, region, x, trial):
    """v with G(v) = x, from `trial` on, all (m, 3); the residuals |G(v) - x| (m,), in world units.

    Backtracking halves a step that does not reduce the residual, or that crosses a cut. A point
    whose steps are halved in vain because of a cut may cross cuts from then on: v may be behind one
    of them, seen from x.
    """
    v = trial = np.where(_is_blocked(deformation, x, trial)[:, None], x, trial)
    residual, share, step = np.full(len(x), np.inf), np.ones(len(x)), np.zeros_like(x)
    passing, close = np.zeros(len(x), bool), _EXACT * _size_of(region.control_points, x)
    for number in range(_TRIALS):
        fit = _Fit(deformation, region.control_points, trial)
        error = x - trial - fit.displacement()
        distance = np.linalg.norm(error, axis=1)
        closer, stopped = distance < residual, np.zeros(len(x), bool)
        if number > 0:
            stopped = closer & ~passing & _is_blocked(deformation, x, trial)
        closer &= ~stopped
        v = np.where(closer[:, None], trial, v)
        residual = np.where(closer, distance, residual)
        share = np.where(closer, 1, share / 2)
        stuck = stopped & (share <= _SMALLEST_SHARE)
        passing |= stuck
        share[stuck] = 1
        moving = (residual > close) & (share > _SMALLEST_SHARE)
        if not moving.any():
            break
        renewed = closer & moving
        jacobian = np.where(renewed[:, None, None], fit.jacobian(), np.eye(3))
        newton = (np.linalg.pinv(_finite(jacobian)) @ error[:, :, None])[:, :, 0]
        step = np.where(renewed[:, None], newton, step)
        trial = v + share[:, None] * step
    cut_off = _is_blocked(deformation, x, v)
    for plane, side in zip(deformation.planes, region.sides):
        cut_off |= side * plane.height(v) < -_ON_PLANE * _size_of(region.control_points, x)
    return v, np.where(cut_off, np.inf, residual)


def _size_of(control_points, x):
    """Length that residual tolerances at `x` (m, 3) are relative to: (m,), world units."""
    return np.maximum(control_points.scale, np.abs(x - control_points.centre).max(axis=1))


def _is_blocked(deformation, x, v):
    """Whether a cut that one can go round is between `x` and `v` (m, 3)."""
    blocks = [cut.blocks(x, v) for cut in deformation.obstacles]
    return np.any(blocks, axis=0) if blocks else np.zeros(len(x), bool)


def _samples(deformation, region, box):
    """Points v (m, 3) over the control points and the `box` with det(J) > 0; G(v) (m, 3)."""
    control_points = region.control_points
    box = guesses.joined(box, guesses.bounds(control_points.deformed))
    v = guesses.cubic_grid(guesses.padded(box, 0.1), _SAMPLES).points()
    v = v[region.holds(deformation.planes, v)]
    fit = _Fit(deformation, control_points, v)
    upright = np.linalg.det(fit.jacobian()) > 0
    return v[upright], (v + fit.displacement())[upright]


def _nearest_sample(deformation, samples, x, tried):
    """For each of `x` (m, 3) the v among `samples` whose G(v) is nearest; its distance (m,).

    Only those farther than `tried` (m,) count.
    """
    best, nearest = x.copy(), np.full(len(x), np.inf)
    for v, image in zip(*samples):
        distance = np.linalg.norm(x - image, axis=1)
        nearer = (distance < nearest) & (distance > tried)
        nearer[nearer] = ~_is_blocked(deformation, x[nearer], v[None])
        best[nearer], nearest[nearer] = v, distance[nearer]
    return best, nearest


def displacement_field(deformation, grid, progress=SILENT):
    displacement = np.empty((grid.size, 3), dtype=np.float32)
    void_distance = np.empty(grid.size, dtype=np.float32) if deformation.cuts else None
    for part in progress.over(_parts(grid.size, deformation)):
        v = grid.points(part.start, part.stop)
        moved = _answers(deformation, v, "displacement")
        displacement[part] = moved
        if deformation.cuts:
            void_distance[part] = _void_distance(deformation, v, v + moved)
    void_distance = void_distance.reshape(grid.shape) if deformation.cuts else None
    return displacement.reshape(*grid.shape, 3), void_distance


def jacobian_field(deformation, grid, progress=SILENT):
    result = np.empty((grid.size, 3, 3), dtype=np.float32)
    for part in progress.over(_parts(grid.size, deformation)):
        v = grid.points(part.start, part.stop)
        result[part] = _answers(deformation, v, "jacobian").swapaxes(1, 2)
    return result.reshape(*grid.shape, 3, 3)


def resample(deformation, arrays, sampling, progress=SILENT):
    results = [np.empty(sampling.target.shape + a.shape[3:], a.dtype) for a in arrays]
    methods = sampling.methods(len(arrays))
    for part, index in _source_index(deformation, sampling, progress):
        for array, method, result in zip(arrays, methods, results):
            flat = result.reshape(-1, *array.shape[3:])
            flat[part] = interpolation.sample(
                array, index, method, sampling.background, sampling.source
            )
    return results


def resample_gradients(deformation, vectors, sampling, normalise, progress=SILENT):
    sampled, transformed, measured = progress.divided(1, 2, 1)
    (moved,) = resample(deformation, [vectors], replace(sampling, background=0.0), sampled)
    transposed = jacobian_field(deformation, sampling.target, transformed)
    result = np.einsum("...ij,...j->...i", transposed, moved)
    if normalise:
        result = _unit(result)
    _, void_distance = displacement_field(deformation, sampling.target, measured)
    return result.astype(np.float32), void_distance


def source_bounds(deformation, sampling, progress=SILENT):
    bounds = interpolation.NO_BOUNDS
    for _, index in _source_index(deformation, sampling, progress):
        bounds = interpolation.joined_bounds(bounds, index, sampling.source.whole)
    return bounds


def _source_index(deformation, sampling, progress):
    """Parts of the target, and where they come from: indices (m, 3) of the whole source."""
    source, target = sampling.source, sampling.target
    matrix, offset = target.whole.index_transform(source.whole)
    to_index = np.linalg.inv(source.index_to_world)
    for part in progress.over(_parts(target.size, deformation)):
        v = target.points(part.start, part.stop)
        moved = _answers(deformation, v, "displacement")
        index = target.indices(part.start, part.stop) + target.first
        index = index @ matrix.T + offset + moved @ to_index.T
        if deformation.cuts and not sampling.continues:
            index[_void_distance(deformation, v, v + moved) < 0] = -np.inf
        yield part, index


def _void_distance(deformation, v, origin):
    return np.min([cut.void_distance(v, origin) for cut in deformation.cuts], axis=0)


def _answers(deformation, points, question, progress=SILENT):
    """The displacement or the Jacobian at `points`, region by region."""
    result = np.empty((len(points), 3, 3) if question == "jacobian" else points.shape)
    for part in progress.over(_parts(len(points), deformation)):
        v, answers = points[part], result[part]
        for region in deformation.regions:
            here = region.holds(deformation.planes, v)
            if here.any():
                fit = _Fit(deformation, region.control_points, v[here])
                answers[here] = getattr(fit, question)()
    return result


def _parts(count, deformation):
    """Slices of at most `_CHUNK` numbers per control point and function."""
    numbers = max(
        len(r.control_points) * (len(r.control_points.basis) + 3) for r in deformation.regions
    )
    step = max(1, _CHUNK // numbers)
    return [slice(start, min(count, start + step)) for start in range(0, count, step)]


class _Fit:
    """The weighted fit of Eq. 2 for each of the points v (m, 3)."""

    def __init__(self, deformation, control_points, v):
        self.control_points, self.kind, self.v = control_points, deformation.kind, v
        alpha = deformation.alpha
        p, q = control_points.rest, control_points.deformed
        offset = q - v[:, None]
        d2 = np.einsum("mia,mia->mi", offset, offset)
        d2 = np.maximum(d2, _ON_CONTROL_POINT * control_points.scale**2)
        # d log(w_i)/dv for w_i = d(v, q_i) / |q_i - v|^(2 alpha), Eq. 27
        slope = 2 * alpha * offset / d2[:, :, None]
        straight = d2
        for cut in deformation.obstacles:
            ratio2, change = _detour(cut, v, q, offset, straight)
            # as if the control point were so much farther away
            d2 = d2 * ratio2 ** (deformation.nu / (2 * alpha))
            slope = slope + deformation.nu * change
        nearest = d2.argmin(axis=1)
        rows = np.arange(len(v))
        nearest_d2 = d2[rows, nearest][:, None]
        self.at_rest = np.isinf(nearest_d2[:, 0])  # no control point can be reached
        # w_i, relative to the largest and times the weight of the control point
        share = np.where(np.isinf(d2), 0, np.where(self.at_rest[:, None], 1, nearest_d2) / d2)
        self.w = control_points.weights * np.where(self.at_rest[:, None], 1, share) ** alpha
        # a common factor of all weights changes nothing, so the nearest one's slope is taken as 0
        self.dw = self.w[:, :, None] * (slope - slope[rows, nearest][:, None])
        self.total = self.w.sum(axis=1)

        self.p_k, self.q_k = p[nearest], q[nearest]
        p, q = p - self.p_k[:, None], q - self.q_k[:, None]
        self.x = v - self.q_k
        # p* and q*, before Eq. 4
        self.p_star, self.q_star = self._mean(p), self._mean(q)
        self.p, self.q = p - self.p_star[:, None], q - self.q_star[:, None]
        self.nearest = nearest
        if self.kind in ROTATION_KINDS:
            self._fit_rotation()
        else:
            self._fit_polynomial()

    def _mean(self, values):
        return np.einsum("mi,mia->ma", self.w, values) / self.total[:, None]

    def jacobian(self):
        """dG/dv: the derivative of l at fixed weights, and of l by the weights.

        The weights enter the optimal fit only through each control point's residual, so
        their part is a sum of dw_i times the influence of control point i on the value.
        """
        through_weights = np.einsum("mic,mia->mca", self._influence(), self.dw)
        jacobian = self._linear_part() + through_weights
        return np.where(self.at_rest[:, None, None], np.eye(3), jacobian)

    def displacement(self):
        """G(v) - v = l(v) - v, Eq. 4 (rotations) and Eq. 26 (affine and polynomial)."""
        return np.where(self.at_rest[:, None], 0, self.moved)

    # Rigid and similarity deformations

    def _fit_rotation(self):
        """The rotation that maximises Eq. 9, and the factor of the similarity kind."""
        # C of Eq. 11
        self.c = np.einsum("mi,mia,mib->mab", self.w, self.p, self.q)
        rank = self.control_points.rotation_rank
        if rank == 2:
            self.rotation = _largest_rotation(self.c)
        elif rank == 1:
            self.rotation = self._rotation_of_line()
        else:
            self.rotation = np.broadcast_to(np.eye(3), self.c.shape)
        self.r_max = np.einsum("mab,mab->m", self.rotation, self.c)
        self.spread = np.einsum("mi,mia,mia->m", self.w, self.q, self.q)
        self.factor = np.ones(len(self.v))
        if self.kind == "similarity":  # mu_s, end of section 2
            np.divide(self.r_max, self.spread, out=self.factor, where=self.spread > 0)
        offset = self.x - self.q_star
        self.turned = np.einsum("mab,mb->ma", self.rotation, offset)
        self.moved = (
            (self.p_k - self.q_k)
            + (self.p_star - self.q_star)
            + (self.factor[:, None] * self.turned - offset)
        )

    def _rotation_of_line(self):
        """Twist-free rotation of C = s a^T b that turns b to a."""
        rows = np.linalg.norm(self.c, axis=2)
        b = _unit(np.take_along_axis(self.c, rows.argmax(axis=1)[:, None, None], axis=1)[:, 0])
        a = _unit(np.einsum("mab,mb->ma", self.c, b))
        b = np.where(np.einsum("mab,ma,mb->m", self.c, a, b)[:, None] < 0, -b, b)
        self.line = a, b
        half = a + b
        opposite = np.linalg.norm(half, axis=1) < 1e-5
        half = np.where(opposite[:, None], 0, _unit(half))
        quaternion = np.hstack([np.sum(half * b, axis=1)[:, None], np.cross(b, half)])
        quaternion[opposite, 1:] = self.control_points.flip_axis
        quaternion[(a == 0).all(axis=1)] = (1, 0, 0, 0)
        return _rotation_matrix(quaternion)

    def _influence(self):
        if self.kind not in ROTATION_KINDS:
            return self._kernel[:, :, None] * self.residual
        turned = np.einsum("mab,mib->mia", self.rotation, self.q)
        residual = self.p - self.factor[:, None, None] * turned
        influence = residual / self.total[:, None, None]
        moved = self.factor[:, None] * self.turned
        if self.control_points.rotation_rank == 2:
            # R^T C = S stays symmetric: (tr(S) I - S) omega = q x R^T p for each control point
            s = np.einsum("mba,mbc->mac", self.rotation, self.c)
            stiffness = (
                np.trace(s, axis1=1, axis2=2)[:, None, None] * np.eye(3)
                - (s + s.swapaxes(1, 2)) / 2
            )
            torque = np.cross(self.q, np.einsum("mba,mib->mia", self.rotation, self.p))
            omega = np.einsum("mab,mib->mia", np.linalg.pinv(_finite(stiffness)), torque)
            omega = np.einsum("mab,mib->mia", self.rotation, omega)
            influence = influence + np.cross(omega, moved[:, None])
        elif self.control_points.rotation_rank == 1:
            influence = influence + np.cross(self._line_turn(), moved[:, None])
        if self.kind == "similarity":
            stretch = np.sum(self.p * turned, axis=2) - self.factor[:, None] * np.sum(
                self.q**2, axis=2
            )
            spread = np.where(self.spread > 0, self.spread, np.inf)
            influence = influence + (stretch / spread[:, None])[:, :, None] * self.turned[:, None]
        return influence

    def _line_turn(self):
        """Angular velocity of the twist-free rotation for a change of each weight."""
        a, b = (axis[:, None] for axis in self.line)
        strength = np.maximum(self.r_max, np.finfo(float).tiny)[:, None, None]
        da = self.p * np.sum(self.q * b, axis=2, keepdims=True) / strength
        db = self.q * np.sum(self.p * a, axis=2, keepdims=True) / strength
        da, db = (
            da - a * np.sum(a * da, axis=2, keepdims=True),
            db - b * np.sum(b * db, axis=2, keepdims=True),
        )
        turned = np.einsum("mab,mib->mia", self.rotation, np.cross(a + b, db))
        divisor = np.maximum(1 + np.sum(a * b, axis=2, keepdims=True), 1e-10)
        return (np.cross(a + b, da) - turned) / divisor

    # Affine and nonlinear polynomial deformations

    def _fit_polynomial(self):
        """Eq. 23 to 26: weighted orthogonal polynomials psi_j, starting from psi_0 = 1.

        The displacement p - q is fitted, so that what the control points leave open stays as in
        the identity map. Degree 1 is the affine kind: the same minimum as Eq. 7.
        """
        basis, local = self.control_points.basis, self.control_points.local(self.v)
        values, at_v = basis.values, basis(local)
        u = (self.p + self.p_star[:, None]) - (self.q + self.q_star[:, None])
        w = self.w

        def inner(f, g):  # Eq. 23
            return np.einsum("mi,mi...,mi...->m...", w, f, g)

        psi_0 = np.ones_like(w)
        orthogonal = [(psi_0, np.ones(len(at_v)), np.zeros((len(at_v), 3)), self.total)]
        slopes = basis.gradient(local) / self.control_points.scale
        for j in range(len(basis)):
            origin = values[self.nearest, j]
            f, f_v, df_v = values[None, :, j] - origin[:, None], at_v[:, j] - origin, slopes[:, j]
            before = inner(f, f)
            for psi, psi_v, dpsi_v, norm in orthogonal:
                c = inner(f, psi) / norm
                f, f_v = f - c[:, None] * psi, f_v - c * psi_v
                df_v = df_v - c[:, None] * dpsi_v
            norm = inner(f, f)
            lost = norm <= _VANISHING * before
            f_v, df_v = np.where(lost, 0, f_v), np.where(lost[:, None], 0, df_v)
            orthogonal.append((f, f_v, df_v, np.where(lost, 1, norm)))

        self.moved = self.p_k - self.q_k
        self.gradient = np.zeros((len(at_v), 3, 3))
        self.residual = u
        self._kernel = np.zeros_like(w)
        for psi, psi_v, dpsi_v, norm in orthogonal:  # Eq. 26
            c = np.einsum("mi,mia,mi->ma", w, u, psi) / norm[:, None]
            self.moved = self.moved + c * psi_v[:, None]
            self.gradient = self.gradient + c[:, :, None] * dpsi_v[:, None]
            self.residual = self.residual - psi[:, :, None] * c[:, None]
            self._kernel = self._kernel + psi * (psi_v / norm)[:, None]

    def _linear_part(self):
        if self.kind in ROTATION_KINDS:
            return self.factor[:, None, None] * self.rotation
        return np.eye(3) + self.gradient


def _detour(cut, v, q, offset, d2):
    """Of the way from each v to each q: (detour / way)^2, and d log(d)/dv / nu of Eq. 28."""
    v = v[:, None]
    blocked = cut.blocks(v, q)
    bend = cut.bend(v, q)
    leg = v - bend
    length = np.linalg.norm(leg, axis=2)
    path = length + np.linalg.norm(q - bend, axis=2)
    closed = blocked & np.isnan(path)
    blocked = blocked & ~closed
    ratio2 = np.where(closed, np.inf, np.where(blocked, np.maximum(path**2 / d2, 1), 1))
    change = -offset / d2[:, :, None] - leg / np.maximum(length * path, 1e-300)[:, :, None]
    return ratio2, np.where(blocked[:, :, None], change, 0)


def _unit(vectors):
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def _largest_rotation(c):
    """The rotation (m, 3, 3) that maximises tr(R^T C), as column matrix p = R q.

    The largest root of the quartic of Eq. 22 is the largest eigenvalue of this symmetric matrix,
    and the eigenvector is the rotation of Eq. 10 as a quaternion (Horn 1987).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.moveaxis(c, 0, -1)
    horn = np.array(
        [
            [xx + yy + zz, zy - yz, xz - zx, yx - xy],
            [zy - yz, xx - yy - zz, xy + yx, zx + xz],
            [xz - zx, xy + yx, yy - xx - zz, yz + zy],
            [yx - xy, zx + xz, yz + zy, zz - xx - yy],
        ]
    )
    scale = np.abs(horn).max(axis=(0, 1))
    horn = _finite(np.moveaxis(horn / np.where(scale > 0, scale, 1), -1, 0))
    return _rotation_matrix(np.linalg.eigh(horn)[1][:, :, -1])


def _finite(matrices):
    """`matrices`, as numpy's decompositions take them: they fail for all if one is not finite."""
    return np.where(np.isfinite(matrices), matrices, 0)


def _rotation_matrix(quaternion):
    """Rotation matrices (m, 3, 3) of unit quaternions (m, 4) = (w, x, y, z)."""
    w, x, y, z = quaternion.T
    return np.moveaxis(
        np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        ),
        -1,
        0,
    )
