"""3D Slicer without its window (the package slicer-core), as a judge of files.

It brings a VTK of its own, which must not meet ours, so it lives in an environment of its own and
runs in a process of its own; `make test` makes it.
"""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

_PYTHON = Path(__file__).resolve().parents[2] / ".venv-slicer/bin/python"

needs_slicer = pytest.mark.skipif(
    not _PYTHON.exists(),
    reason="no .venv-slicer with the package slicer-core, which `make test` makes where it can",
)


_MOVE = """
import json, sys
import slicer
scene = slicer.vtkMRMLScene()
for path in sys.argv[2:]:
    storage, node = slicer.vtkMRMLTransformStorageNode(), slicer.vtkMRMLTransformNode()
    scene.AddNode(storage)
    scene.AddNode(node)
    storage.SetFileName(path)
    assert storage.ReadData(node), path
    for transform in (node.GetTransformFromParent(), node.GetTransformToParent()):
        print(json.dumps([transform.TransformPoint(p) for p in json.loads(sys.argv[1])]))
"""


def moved(points, paths):
    """Points (n, 3) in LPS moved by transforms, from and to the parent: (files, 2, n, 3)."""
    to_ras = [-1, -1, 1]  # Slicer's own world
    paths = [Path(path).resolve() for path in paths]
    lines = run(_MOVE, json.dumps((points * to_ras).tolist()), *paths).splitlines()
    found = [json.loads(line) for line in lines[-2 * len(paths) :]]
    return np.reshape(found, (len(paths), 2, -1, 3)) * to_ras


def run(code, *arguments):
    """What Slicer's Python prints when it runs `code` with `sys.argv[1:] = arguments`."""
    usual = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("PYTHON") and name != "LD_LIBRARY_PATH"
    }
    command = [str(_PYTHON), "-c", code, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", env=usual, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
