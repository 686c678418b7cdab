"""Builds the kernels of all maps, so that the first cut or another kind does not wait for them.

A child process does it, since a build would block the editor; drivers keep the kernels on the disk.
"""

from __future__ import annotations

import os
import subprocess
from contextlib import suppress

import numpy as np

from vtk_mls import Deformation, HalfPlane, Plane, Surface
from vtk_mls.base import child_process
from vtk_mls.base.grid import Grid
from vtk_mls.model import kinds
from vtk_mls.rendering import map_layers

_REST = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)])
_DRAG = np.array([(0.1, 0.0, 0)])
_MIDDLE = (0.5, 0.5, 0.5)
# Along each axis: all of a few nodes are evaluated; of many nodes, within a tolerance, a part.
_NODES = 8, 32
_CUTS = (
    (HalfPlane(_MIDDLE, (1, 0, 0), (0, 0, 1)),),
    (Plane(_MIDDLE, (1, 0, 0)),),
    (Surface([(0.5, 0, 0), (0.5, 1, 0), (0.5, 0, 1)], [(0, 1, 2)]),),
    (),
)


def maps(kind, degree, map_tolerance, device):
    """Deformations of each kind with each cut; those of `kind` come first."""
    for other in sorted(kinds.KINDS, key=lambda other: other != kind):
        for cuts in _CUTS:
            yield Deformation(
                _REST,
                _REST + _DRAG,
                kind=other,
                degree=degree,
                cuts=cuts,
                map_tolerance=map_tolerance,
                device=device,
            )


def prepare(state, report):
    """Build in a child for a `State`; `report(done, count)` is called as it goes on."""
    options = state.kind, state.degree, state.map_tolerance, state.device
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with child_process.started(f"{__name__}:build", *options, **streams) as (child, _):
        for line in child.stdout:
            report(*map(int, line.split()))


def build(folder, kind, degree, map_tolerance, device):
    """Build with a low priority, and print how many maps are ready and how many there are."""
    if hasattr(os, "nice"):
        os.nice(19)
    deformations = [*maps(kind, degree, map_tolerance, device)]
    for done, deformation in enumerate(deformations):
        print(done, len(deformations), flush=True)
        # the editor reports a map that cannot be built when it is used
        with suppress(ValueError, RuntimeError, MemoryError):
            for nodes in _NODES:
                grid = Grid((nodes,) * 3, (0, 0, 0), (1.2 / nodes,) * 3)
                map_layers.layers(deformation, grid)
            deformation.forward_field(_REST)
