"""Cases in which every two values of any two parameters meet at least once.

Most defects show with one value or with two that meet; all combinations of all values cost many
times as much and find hardly more.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

import pytest

# Values that need no case of their own, because the kernels of degree 2 serve degree 3.
ALIKE = {"polynomial3", "polynomial-3"}


@dataclass(frozen=True)
class Rare:
    """A value that needs no case of its own on each change."""

    value: object


def rare(*values):
    """Values of `paired` for which another test that runs on each change has a case."""
    return map(Rare, values)


def paired(**parameters):
    """A decorator for a test: `pytest.mark.parametrize` by `cases` of the parameters' values.

    The first cases, in which each value appears but `rare` ones, run on each change; the others in
    `make matrix`.
    """
    lists = [list(values) for values in parameters.values()]
    common = [
        tuple(i for i, value in enumerate(values) if not isinstance(value, Rare))
        for values in lists
    ]
    rows = list(product(*common))
    names = [[_name(values[i]) for values, i in zip(lists, row)] for row in rows]
    first = [rows[i] for i in few_with_each_value(names)]
    marked = [
        pytest.param(
            *(value.value if isinstance(value, Rare) else value for value in row),
            id="-".join(map(_name, row)),
            marks=[] if i < len(first) else [pytest.mark.matrix],
        )
        for i, row in enumerate(cases(*lists, first=first))
    ]
    return pytest.mark.parametrize(tuple(parameters), marked)


def one_of(count, values):
    """Parameters of a test: every `count`-th runs on each change, the others in `make matrix`."""
    return [
        pytest.param(value, marks=[pytest.mark.matrix] * (i % count > 0))
        for i, value in enumerate(values)
    ]


def few_with_each_value(rows):
    """Indices of a few rows in which each value of each column appears, but some that are `ALIKE`.

    The next row is always the one with most new values, and among these the one whose other values
    come first: so tests have many pairs in common, and a kernel that one of them builds is there
    for the others. Lists of kinds, cuts and alphas have the same order in all tests for this.
    """
    order = [{value: i for i, value in enumerate(dict.fromkeys(column))} for column in zip(*rows)]
    ranks = [[places[value] for places, value in zip(order, row)] for row in rows]
    left, few, found = dict(enumerate(rows)), [], set()
    while left:

        def rank(i):
            pairs = enumerate(rows[i])
            is_new = [pair not in found and pair[1] not in ALIKE for pair in pairs]
            return sum(is_new), -sum(r for r, new in zip(ranks[i], is_new) if not new)

        best = max(left, key=rank)
        if not rank(best)[0] and few:
            break
        found.update(enumerate(left.pop(best)))
        few.append(best)
    return few


def cases(*lists, first=()):
    """Tuples with a value of each list; any two values of different lists are in one of them.

    The same for the same lists: those with the indices `first`, then of all combinations always the
    first that has most new pairs.
    """
    sizes = [range(len(values)) for values in lists]
    if not all(sizes):
        return []
    combined = list(product(*sizes))
    rows = list(first)
    open_pairs = {pair for row in combined for pair in _pairs(row)}
    open_pairs.difference_update(*map(_pairs, rows))
    while open_pairs:
        row = max(combined, key=lambda row: len(open_pairs.intersection(_pairs(row))))
        rows.append(row)
        open_pairs.difference_update(_pairs(row))
    if len(lists) == 1:
        rows += [row for row in combined if row not in rows]
    return [tuple(values[i] for values, i in zip(lists, row)) for row in rows]


def _pairs(row):
    return combinations(enumerate(row), 2)


def _name(value):
    if isinstance(value, Rare):
        return _name(value.value)
    if isinstance(value, tuple):
        return "".join(map(str, value))
    return str(value)
