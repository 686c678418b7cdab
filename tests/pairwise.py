"""Cases in which every two values of any two parameters meet at least once.

Most defects show with one value or with two that meet; all combinations of all values cost many
times as much and find hardly more.
"""

from __future__ import annotations

from itertools import combinations, product

import pytest

# Values that count as another one, because the same kernels serve both.
ALIKE = {"polynomial3": "polynomial2"}


def paired(**parameters):
    """A decorator for a test: `pytest.mark.parametrize` by `cases` of the parameters' values.

    A few cases, in which each value appears, run on each change; the others in `make matrix`.
    """
    rows = cases(*(list(values) for values in parameters.values()))
    names = [tuple(map(_name, row)) for row in rows]
    few = few_with_each_value(names)
    marked = [
        pytest.param(*row, id="-".join(name), marks=[] if i in few else [pytest.mark.matrix])
        for i, (row, name) in enumerate(zip(rows, names))
    ]
    return pytest.mark.parametrize(tuple(parameters), marked)


def one_of(count, values):
    """Parameters of a test: every `count`-th runs on each change, the others in `make matrix`."""
    return [
        pytest.param(value, marks=[pytest.mark.matrix] * (i % count > 0))
        for i, value in enumerate(values)
    ]


def few_with_each_value(rows):
    """Numbers of a few rows in which each value of each column appears.

    Each is the row with most new values, and among these the one whose other values come first: so
    tests have many pairs in common, and a kernel that one of them builds is there for the others.
    """
    rows = [tuple(ALIKE.get(value, value) for value in row) for row in rows]
    order = [{value: i for i, value in enumerate(dict.fromkeys(column))} for column in zip(*rows)]
    ranks = [[places[value] for places, value in zip(order, row)] for row in rows]
    left, few, found = dict(enumerate(rows)), set(), set()
    while left:

        def rank(i):
            is_new = [pair not in found for pair in enumerate(rows[i])]
            return sum(is_new), -sum(r for r, new in zip(ranks[i], is_new) if not new)

        best = max(left, key=rank)
        if not rank(best)[0] and few:
            break
        found.update(enumerate(left.pop(best)))
        few.add(best)
    return few


def cases(*lists):
    """Tuples with a value of each list; any two values of different lists are in one of them.

    The same for the same lists: of all combinations always the first that has most new pairs.
    """
    sizes = [range(len(values)) for values in lists]
    if not all(sizes):
        return []
    combined = list(product(*sizes))
    open_pairs = {pair for row in combined for pair in _pairs(row)}
    rows = []
    while open_pairs:
        row = max(combined, key=lambda row: len(open_pairs.intersection(_pairs(row))))
        rows.append(row)
        open_pairs.difference_update(_pairs(row))
    if not rows:  # a single list
        rows = combined
    return [tuple(values[i] for values, i in zip(lists, row)) for row in sorted(rows)]


def _pairs(row):
    return combinations(enumerate(row), 2)


def _name(value):
    if isinstance(value, tuple):
        return "".join(map(str, value))
    return str(value)
