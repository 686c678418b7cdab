"""Fixtures of the core."""

import pytest
from control_point_sets import DEVICES
from cut_shapes import SHAPES


@pytest.fixture(params=["reference", *DEVICES])
def device(request):
    return request.param


@pytest.fixture(params=SHAPES)
def cuts(request):
    return SHAPES[request.param]
