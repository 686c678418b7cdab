"""Progress of long computations, reported to a callback that may stop them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import accumulate
from typing import TypeVar, Union

Step = TypeVar("Step")


class Aborted(RuntimeError):
    """The `progress` callback asked to stop."""


class Progress:
    """A part of a computation, from one fraction of the whole to another.

    Progress is reported before each step, and not after the last, since another part may follow.
    `whole` reports 1 at the end. So fractions increase, and 1 is reported once.

    `over` iterates over equal steps; `divided` makes a Progress for each of several parts, `parts`
    and `chunks` for equal ones.
    """

    def __init__(
        self, report: Callable[[float], None] | None = None, begin: float = 0.0, end: float = 1.0
    ):
        self._report, self._begin, self._end = report, begin, end

    def report(self, fraction: float) -> None:
        """Report that a `fraction` of this part is done, below 1; Aborted if it is to stop."""
        if self._report is not None:
            self._report(self._at(fraction))

    def over(self, steps: Sequence[Step]) -> Iterator[Step]:
        """Iterate over `steps` of equal duration."""
        for i, step in enumerate(steps):
            self.report(i / len(steps))
            yield step

    def divided(self, *shares: float) -> list[Progress]:
        """A Progress for each of consecutive parts, with durations in proportion to `shares`."""
        ends = [self._at(done / sum(shares)) for done in accumulate(shares)]
        return [
            Progress(self._report, begin, end) for begin, end in zip([self._begin, *ends], ends)
        ]

    def parts(self, steps: Sequence[Step]) -> Iterator[tuple[Step, Progress]]:
        """`steps` of equal duration, and a Progress for each."""
        return zip(steps, self.divided(*[1] * len(steps)))

    def chunks(self, count: int, size: int) -> Iterator[tuple[slice, Progress]]:
        """Slices of `count` items, at most `size` in each, and a Progress for each."""
        return self.parts([slice(i, min(i + size, count)) for i in range(0, count, size)])

    def _at(self, fraction: float) -> float:
        """The fraction of the whole at a `fraction` of this part."""
        return min(self._begin + (self._end - self._begin) * fraction, self._end)


# A callback that stops the computation by a true return value, or a part of a computation.
ProgressLike = Union[Callable[[float], object], Progress, None]


@contextmanager
def whole(progress: ProgressLike) -> Iterator[Progress]:
    """The Progress for an argument `progress`.

    The end is reported to a callback, but not to a Progress, which is a part of a computation.
    """
    if isinstance(progress, Progress):
        yield progress
        return
    part = SILENT if progress is None else Progress(_increasing(progress))
    yield part
    part.report(1.0)


def _increasing(callback):
    """Report increasing fractions to `callback`, and raise Aborted if it returns a true value."""
    last = 0.0

    def report(fraction):
        nonlocal last
        last = max(last, fraction)  # a computation restarts when it runs out of memory
        if callback(last):
            raise Aborted(f"stopped at {last:.0%} as `progress` asked")

    return report


SILENT = Progress()  # reports nothing
