"""Fixtures of the filters."""

import pytest
from mesh_fixtures import any_mesh
from smooth_images import deform
from vtk_fixtures import messages, opengl

__all__ = ["any_mesh", "deform", "messages", "opengl"]


@pytest.fixture
def coarse_fits(monkeypatch):
    """A grid is fitted by few samples: the reference device takes long for all."""
    monkeypatch.setattr("vtk_mls.queries.arrival.FITTED_SAMPLES", 12)
