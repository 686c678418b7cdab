"""How far a long work has come, told to a callback that may stop it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import accumulate
from typing import TypeVar

Step = TypeVar("Step")


class Aborted(RuntimeError):
    """The `progress` callback asked to stop."""


class Progress:
    """A part of a work, from one fraction of the whole to another.

    A work says how far it has come before each of its steps, never after the last: what follows on
    that may be another part. Only who began the whole says that it is done (`whole`). So fractions
    grow, and the callback hears of 1 once, when nothing is left to do. Each time it may stop the
    work.

    A work that consists of steps alike goes through them by `over`; one with parts that report on
    their own gives each a Progress of those that `divided` makes.
    """

    def __init__(
        self, report: Callable[[float], None] | None = None, begin: float = 0.0, end: float = 1.0
    ):
        self._report, self._begin, self._end = report, begin, end

    def report(self, fraction: float) -> None:
        """Say that a `fraction` of this part is done, below 1.

        Raises
        ------
        Aborted
        """
        if self._report is not None:
            self._report(self._at(fraction))

    def over(self, steps: Sequence[Step]) -> Iterator[Step]:
        """The items of the sequence `steps`, one after the other, each as long as the others."""
        for number, step in enumerate(steps):
            self.report(number / len(steps))
            yield step

    def divided(self, *shares: float) -> list[Progress]:
        """A Progress for each of some parts, one after the other, as long as `shares` say."""
        ends = [self._at(done / sum(shares)) for done in accumulate(shares)]
        return [
            Progress(self._report, begin, end) for begin, end in zip([self._begin, *ends], ends)
        ]

    def _at(self, fraction: float) -> float:
        """The fraction of the whole at a `fraction` of this part."""
        return min(self._begin + (self._end - self._begin) * fraction, self._end)


# What a question takes: a callback that stops the work by a true answer, or a part of a work.
ProgressLike = Callable[[float], object] | Progress | None


@contextmanager
def whole(progress: ProgressLike) -> Iterator[Progress]:
    """The Progress of a question, by its argument `progress`.

    A callback hears of the end; a Progress does not, for it is a part of a work that goes on.
    """
    if isinstance(progress, Progress):
        yield progress
        return
    begun = SILENT if progress is None else Progress(_rising(progress))
    yield begun
    begun.report(1.0)


def _rising(callback):
    """`callback`, which never hears less than before, and whose answer to stop is an exception."""
    last = 0.0

    def report(fraction):
        nonlocal last
        last = max(last, fraction)  # short of memory, a question begins again
        if callback(last):
            raise Aborted(f"stopped at {last:.0%} as `progress` asked")

    return report


SILENT = Progress()  # of a work that nobody waits for
