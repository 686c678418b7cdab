"""Fixtures of OME-Zarr."""

import numpy as np
import pytest
from command_fixtures import numpy_computes, refused
from zarr_images import HANDLES

__all__ = ["numpy_computes", "refused"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with handles.csv."""
    monkeypatch.chdir(tmp_path)
    np.savetxt("handles.csv", HANDLES, delimiter=",")
    return tmp_path
