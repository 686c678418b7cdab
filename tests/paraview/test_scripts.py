"""The plugin in real ParaViews: the scripts of tests/paraview and the pvpython example, in each."""

from __future__ import annotations

from pathlib import Path

import pytest
from paraviews import PICTURES, PROJECT, display, paraview  # noqa: F401  fixtures

SCRIPTS = sorted(
    path.relative_to(PROJECT)
    for pattern in ("tests/paraview/check_*.py", "examples/paraview_*.py")
    for path in PROJECT.glob(pattern)
)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_script(paraview, display, script, request):
    pictures = PICTURES / request.node.callspec.id.partition("-")[0]
    (PROJECT / pictures).mkdir(parents=True, exist_ok=True)
    paraview.check(script, pictures, display=display)


@pytest.mark.parametrize("script", ["exception.py", "vtk_error.py"])
def test_harness_can_fail(paraview, script):
    with pytest.raises(AssertionError, match=script):
        paraview.check(Path("tests/paraview/failing") / script)
