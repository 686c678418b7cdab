"""Fixtures of the core."""

import pytest
from cut_shapes import SHAPES


@pytest.fixture(params=SHAPES)
def cuts(request):
    return SHAPES[request.param]
