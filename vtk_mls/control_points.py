"""A set of control points, prepared once in float64 for every engine.

The kernels work in float32. What they cannot decide safely is decided here: which control points
are distinct, what the set determines (a line has no twist, a plane no affine thickness, few points
no cubic), and the local frame in which coordinates are small.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

KINDS = ("affine", "rigid", "similarity", "polynomial")
ROTATION_KINDS = ("rigid", "similarity")

# Exponents of the monomials of degree 1, 2 and 3; opencl/basis.cl has the same order.
MONOMIALS = np.array(
    [
        *[(1, 0, 0), (0, 1, 0), (0, 0, 1)],
        *[(2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (1, 0, 1), (0, 1, 1)],
        *[(3, 0, 0), (0, 3, 0), (0, 0, 3), (2, 1, 0), (2, 0, 1)],
        *[(1, 2, 0), (0, 2, 1), (1, 0, 2), (0, 1, 2), (1, 1, 1)],
    ]
)
MONOMIAL_COUNT = {1: 3, 2: 9, 3: 19}

# Below this share of its size a function counts as zero on the control points. float32 input
# that was meant to be exactly flat is flat to about 1e-7.
RANK_TOLERANCE = 1e-5
# Control points are in one place if they are no farther apart than this share of the world.
_ONE_PLACE = 1e-12
# The rotation about a line of control points hangs on the product of the two sets' widths.
TWIST_TOLERANCE = 1e-5


@dataclass(frozen=True, eq=False)
class ControlPoints:
    """Distinct control points with their classification and local frame.

    Attributes
    ----------
    rest, deformed : (n, 3) float64, world coordinates
        p and q. Control points with the same q are merged into their weighted mean, which leaves
        every kind of map as it is; a set that moves as one is merged into a single point.
    weights : (n,) float64
        Factor of each control point.
    world : float, world units
        The size of all that is deformed: the scale where the control points are in one place.
    centre, scale : (3,) float64 and float, world coordinates
        The local frame: (x - centre) / scale. All tolerances are in its units.
    mean_displacement : (3,) float64, world units
        Mean of p - q.
    rotation_rank : int
        0: no rotation is determined, 1: all but the twist about a line, 2: all of it.
    flip_axis : (3,) float64
        Unit vector, normal to the line of rank 1: the axis of a turn by exactly 180 degrees.
    basis : Basis
        Functions that the affine and polynomial kinds fit.
    """

    rest: np.ndarray
    deformed: np.ndarray
    weights: np.ndarray
    degree: int
    world: float
    centre: np.ndarray = field(init=False)
    scale: float = field(init=False)
    mean_displacement: np.ndarray = field(init=False)
    rotation_rank: int = field(init=False)
    flip_axis: np.ndarray = field(init=False)
    basis: Basis = field(init=False)

    def __post_init__(self):
        rest, deformed, weights = _merge(self.rest, self.deformed, self.weights)
        centre = deformed.mean(axis=0)
        size = np.abs(deformed - centre).max()
        values = {
            "rest": rest,
            "deformed": deformed,
            "weights": weights,
            "centre": centre,
            "scale": float(size if size > _ONE_PLACE * self.world else self.world),
            "mean_displacement": (rest - deformed).mean(axis=0),
        }
        values["rotation_rank"], values["flip_axis"] = _rotation_rank(rest, deformed)
        local = (deformed - centre) / values["scale"]
        values["basis"] = Basis.on(local, self.degree)
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.rest)

    def local(self, points) -> np.ndarray:
        """`points` (m, 3) of the world in the local frame."""
        return (points - self.centre) / self.scale


@dataclass(frozen=True, eq=False)
class Basis:
    """Polynomials that are orthonormal on the control points, up to a constant each.

    Each degree adds only what the control points can tell from lower degrees (singular value
    above `RANK_TOLERANCE`), so a fit in this basis never divides by a vanishing norm, and what a
    degenerate set cannot determine stays as it is in the identity map.

    Attributes
    ----------
    coefficients : (functions, monomials) float64
        Of the `MONOMIALS` in local coordinates.
    values : (n, functions) float64
        At the control points.
    """

    coefficients: np.ndarray
    values: np.ndarray

    @classmethod
    def on(cls, local: np.ndarray, degree: int) -> Basis:
        """Basis of the polynomials up to `degree` on the points `local` (n, 3)."""
        n, monomials = len(local), MONOMIAL_COUNT[degree]
        values = np.ones((n, 1))
        coefficients = np.zeros((1, monomials))
        orders = MONOMIALS[:monomials].sum(axis=1)
        for order in range(1, degree + 1):
            of_order = np.flatnonzero(orders == order)
            # with these factors the norm of a form's coefficients does not depend on the axes
            factor = np.sqrt([_multinomial(e) for e in MONOMIALS[of_order]])
            forms = np.zeros((len(of_order), monomials))
            forms[np.arange(len(of_order)), of_order] = factor
            sampled = monomial_values(local, degree) @ forms.T
            size = np.linalg.norm(sampled, 2)
            for _ in range(2):  # twice is enough
                shadow = values.T @ sampled / n
                sampled = sampled - values @ shadow
                forms = forms - shadow.T @ coefficients
            _, singular, mix = np.linalg.svd(sampled, full_matrices=False)
            kept = singular > RANK_TOLERANCE * size
            mix = mix[kept] * (np.sqrt(n) / singular[kept])[:, None]
            values = np.hstack([values, sampled @ mix.T])
            coefficients = np.vstack([coefficients, mix @ forms])
        coefficients = coefficients[1:]
        return cls(coefficients, monomial_values(local, degree) @ coefficients.T)

    def __len__(self) -> int:
        return len(self.coefficients)

    def __call__(self, local: np.ndarray) -> np.ndarray:
        """Values (m, functions) at `local` (m, 3)."""
        return monomial_values(local, self._degree) @ self.coefficients.T

    def gradient(self, local: np.ndarray) -> np.ndarray:
        """Derivatives (m, functions, 3) with respect to local coordinates."""
        return np.einsum("jm,kma->kja", self.coefficients, monomial_gradients(local, self._degree))

    @property
    def _degree(self) -> int:
        return {count: degree for degree, count in MONOMIAL_COUNT.items()}[
            self.coefficients.shape[1]
        ]


def monomial_values(x: np.ndarray, degree: int) -> np.ndarray:
    """All monomials (m, monomials) of degree 1 to `degree` at `x` (m, 3)."""
    return np.prod(x[:, None, :] ** MONOMIALS[: MONOMIAL_COUNT[degree]], axis=2)


def monomial_gradients(x: np.ndarray, degree: int) -> np.ndarray:
    """Derivatives (m, monomials, 3) of `monomial_values`."""
    exponents = MONOMIALS[: MONOMIAL_COUNT[degree]]
    gradients = []
    for axis in range(3):
        lowered = exponents.copy()
        lowered[:, axis] = np.maximum(lowered[:, axis] - 1, 0)
        gradients.append(exponents[:, axis] * np.prod(x[:, None, :] ** lowered, axis=2))
    return np.stack(gradients, axis=2)


def _multinomial(exponents) -> float:
    factorial = np.array([1, 1, 2, 6])
    return factorial[sum(exponents)] / np.prod(factorial[exponents])


def _merge(rest, deformed, weights):
    """Weighted means of the control points that share q; one point if all of them move alike."""
    _, group = np.unique(deformed, axis=0, return_inverse=True)
    group = group.ravel()
    if (rest - deformed == rest[0] - deformed[0]).all():
        group = np.zeros_like(group)
    count = group.max() + 1
    if count == len(rest):
        return rest, deformed, weights
    total = np.bincount(group, weights)

    def mean(points):
        offset = points - points[0]  # keeps the digits of large coordinates
        sums = np.stack([np.bincount(group, weights * c) for c in offset.T], axis=1)
        return points[0] + sums / total[:, None]

    merged = mean(deformed)
    if count == 1:  # p - q exactly as given
        return merged + (rest[:1] - deformed[:1]), merged, total
    return mean(rest), merged, total


def _rotation_rank(rest, deformed):
    """What the cross-covariance C of Eq. 11 determines of the rotation, whatever the weights."""
    lengths, directions = [], []
    for points in (rest, deformed):
        _, singular, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
        lengths.append(singular if len(singular) > 1 else np.zeros(2))
        directions.append(axes[0])
    spread = [s[0] > 1e-12 * np.abs(points).max() for s, points in zip(lengths, (rest, deformed))]
    if not all(spread):
        return 0, np.array([1.0, 0.0, 0.0])
    (p1, p2), (q1, q2) = (s[:2] for s in lengths)
    rank = 2 if (p2 / p1) * (q2 / q1) > TWIST_TOLERANCE else 1
    line = directions[0] if p2 / p1 < q2 / q1 else directions[1]
    normal = np.cross(line, np.eye(3)[np.abs(line).argmin()])
    return rank, normal / np.linalg.norm(normal)
