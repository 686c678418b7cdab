"""Fixtures of file formats."""

import pytest
from command_fixtures import files, numpy_computes, refused
from vtk_fixtures import messages

__all__ = ["files", "messages", "numpy_computes", "refused"]


@pytest.fixture
def disk():
    """Set how many bytes a file may have; a file system that is full is the same to a writer."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
