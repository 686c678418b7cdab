"""Control points that an algorithm has by its properties."""

from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import as_float, short_repr


class OwnControlPoints:
    """An algorithm with the properties RestPoints, DeformedPoints and Weights."""

    def _listed_control_points(self, rest=None, deformed=None, weights=None):
        """p and q (n, 3) float64, world coordinates, and weights (n,) float64 or None.

        `rest` replaces RestPoints; `deformed` and `weights` are defaults for empty lists.
        ValueError if the lists differ in length, or do not hold numbers.
        """
        if rest is None:
            rest = as_float_rows("RestPoints", self.GetRestPoints(), (3,))

        def listed(name, values, row, default):
            values = as_float_rows(name, values, row)
            if len(values) not in (0, len(rest)):
                raise InputError(
                    f"must be none or one for each of the {len(rest)} rest points, "
                    f"got {len(values)}",
                    argument=name,
                )
            return values if len(values) else default

        deformed = rest if deformed is None else deformed
        deformed = listed("DeformedPoints", self.GetDeformedPoints(), (3,), deformed)
        return rest, deformed, listed("Weights", self.GetWeights(), (), weights)


def as_float_rows(name, values, row):
    """The float64 array of shape (n, *row) of the property `name`."""
    try:
        return as_float(name, values).reshape(len(values), *row)
    except (TypeError, ValueError):
        expected = f"rows of {row[0]} numbers" if row else "numbers"
        raise InputError(f"must be {expected}, got {short_repr(values)}", argument=name) from None
