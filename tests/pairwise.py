"""Cases in which every two values of any two parameters meet at least once.

Most defects show with one value or with two that meet; all combinations of all values cost many
times as much and find hardly more.
"""

from __future__ import annotations

from itertools import combinations, product

import pytest


def paired(**parameters):
    """A decorator for a test: `pytest.mark.parametrize` by `cases` of the parameters' values."""
    rows = cases(*(list(values) for values in parameters.values()))
    ids = ["-".join(map(_name, row)) for row in rows]
    return pytest.mark.parametrize(tuple(parameters), rows, ids=ids)


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
