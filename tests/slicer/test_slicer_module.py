"""The module for 3D Slicer, in slicer-core: real nodes, events and views, without a window."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / ".venv-slicer/bin/python"
# Slicer's packages come first: its VTK must not meet ours.
RUN = """
import sys
sys.path.insert(0, sys.argv[1])
sys.path += sys.argv[2].split(":")
import pytest
sys.exit(pytest.main(["--noconftest", "-p", "no:cacheprovider", "-c", "/dev/null", *sys.argv[3:]]))
"""


@pytest.mark.skipif(
    not PYTHON.exists(),
    reason="no .venv-slicer with the package slicer-core, which `make test` makes where it can",
)
def test_module_in_slicer_core(tmp_path):
    packages = ":".join(path for path in sys.path if path.endswith("site-packages"))
    checks = Path(__file__).with_name("module_checks.py")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PYTEST"))}
    done = subprocess.run(
        [PYTHON, "-c", RUN, ROOT, packages, "-q", "--rootdir", tmp_path, checks],
        capture_output=True,
        encoding="utf-8",
        env={**environment, "HARDENED": str(tmp_path / "hardened.npz")},
        timeout=600,
    )
    assert done.returncode == 0, done.stdout[-8000:] + done.stderr[-2000:]
    compare_with_simpleitk(**np.load(tmp_path / "hardened.npz"))


def compare_with_simpleitk(before, places, values):
    """Values of Slicer's hardened volume, and of SimpleITK at the places in LPS they came from."""
    image = sitk.GetImageFromArray(before)
    image.SetSpacing((3.0,) * 3)
    image.SetOrigin((-58.5,) * 3)
    index = np.array([image.TransformPhysicalPointToContinuousIndex(place) for place in places])
    inside = ((index > 0) & (index < np.subtract(image.GetSize(), 1))).all(axis=1)
    assert inside.sum() > 300
    expected = [image.EvaluateAtContinuousIndex(place) for place in index[inside]]
    assert values[inside] == pytest.approx(np.array(expected), abs=1e-3)
