"""Fixtures of landmarks."""

import pytest
from landmark_pairs import planted_pairs


@pytest.fixture
def pairs(rng):
    """p and q of 40 pairs, two of them swapped."""
    p, q, _, _ = planted_pairs(rng, 40)
    return p, q
