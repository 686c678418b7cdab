"""Fixtures of the command line."""

import numpy as np
import pytest
from command_fixtures import disk, files, numpy_computes, refused
from vtk_fixtures import DEFORMED, REST, messages

__all__ = ["disk", "files", "messages", "numpy_computes", "refused"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, but for handles.csv, as the current one."""
    monkeypatch.chdir(tmp_path)
    np.savetxt("handles.csv", np.hstack([REST, DEFORMED]), "%.17g", ",")
    return tmp_path
