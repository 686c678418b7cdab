"""Fixtures of PyVista."""

import pytest
from vtk_fixtures import opengl

__all__ = ["opengl"]


@pytest.fixture
def numpy_computes(monkeypatch):
    """For tests of data rather than of kernels."""
    monkeypatch.setenv("VTK_MLS_DEVICE", "reference")
