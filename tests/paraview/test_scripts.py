"""The scripts `check_*.py` and the pvpython example, in all installed ParaViews."""

from __future__ import annotations

from pathlib import Path

import pytest
from paraviews import PICTURES, PROJECT

SCRIPTS = sorted(
    path.relative_to(PROJECT)
    for pattern in ("tests/paraview/check_*.py", "examples/paraview_*.py")
    for path in PROJECT.glob(pattern)
)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_script(paraview, display, script, request):
    paraview.check(script, _pictures(request), display=display)


def _pictures(request):
    """A folder for the pictures of a ParaView, relative to the project."""
    pictures = PICTURES / request.node.callspec.id.partition("-")[0]
    (PROJECT / pictures).mkdir(parents=True, exist_ok=True)
    return pictures


@pytest.mark.parametrize("script", ["exception.py", "vtk_error.py"])
def test_harness_can_fail(paraview, script):
    with pytest.raises(AssertionError, match=script):
        paraview.check(Path("tests/paraview/failing") / script)
