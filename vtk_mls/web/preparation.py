"""Has the kernels of all maps built, so that no first cut or other kind waits for them.

Run as a program, for what drivers build is kept on the disk, and a build would hold up the editor:
it prints how many maps are ready and how many there are, a line for each.
"""

from __future__ import annotations

import asyncio
import os
import sys
from contextlib import suppress

import numpy as np

from vtk_mls import Deformation, HalfPlane, Plane, Surface, kinds
from vtk_mls.base.grid import Grid
from vtk_mls.rendering import map_layers

_REST = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)])
_DRAG = np.array([(0.1, 0.0, 0)])
_MIDDLE = (0.5, 0.5, 0.5)
# Along each axis: so few that all are evaluated, and so many that within a tolerance not all are.
_NODES = 8, 32
_CUTS = (
    (HalfPlane(_MIDDLE, (1, 0, 0), (0, 0, 1)),),
    (Plane(_MIDDLE, (1, 0, 0)),),
    (Surface([(0.5, 0, 0), (0.5, 1, 0), (0.5, 0, 1)], [(0, 1, 2)]),),
    (),
)


def maps(kind, degree, map_tolerance, device):
    """Deformations of each kind with each cut, those of a kind first."""
    others = [each for each in kinds.KINDS if each != kind]
    for each in (kind, *others):
        for cuts in _CUTS:
            yield Deformation(
                _REST,
                _REST + _DRAG,
                kind=each,
                degree=degree,
                cuts=cuts,
                map_tolerance=map_tolerance,
                device=device,
            )


async def prepare(state, told):
    """Run this program for a `State`; `told` is called with what it prints, as ints."""
    of_state = state.kind, str(state.degree), str(state.map_tolerance), state.device or ""
    child = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", __name__, *of_state),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
    )
    async for line in child.stdout:
        told(*map(int, line.split()))
    await child.wait()


def main(kind, degree, map_tolerance, device):
    """Build, while others have the processor first."""
    if hasattr(os, "nice"):
        os.nice(19)
    wanted = [*maps(kind, int(degree), float(map_tolerance), device or None)]
    for done, deformation in enumerate(wanted):
        print(done, len(wanted), flush=True)
        # what cannot be built is told where it is wanted
        with suppress(ValueError, RuntimeError, MemoryError):
            for nodes in _NODES:
                grid = Grid((nodes,) * 3, (0, 0, 0), (1.2 / nodes,) * 3)
                map_layers.layers(deformation, grid)
            deformation.forward_field(_REST)


if __name__ == "__main__":
    with suppress(BrokenPipeError):  # the page's server has ended
        main(*sys.argv[1:])
