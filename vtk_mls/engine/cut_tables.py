"""Cuts as the kernels read them: float32 tables in the local frame of a region."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vtk_mls.cuts import HalfPlane, Surface

# Tables in the order of CUT_PARAMETERS in opencl/cuts.cl.
BEFORE_SURFACES = ("planes", "index_planes", "sides", "half_planes", "frames")
SURFACES = ("surfaces", "triangles", "edges")


@dataclass(frozen=True)
class CutTables:
    """Build constants and tables of some cuts."""

    constants: list
    tables: dict
    surface_count: int


def cut_tables(deformation, region, grid=None) -> CutTables:
    """The cuts of `deformation` in the local frame of `region`; planes also by index of `grid`."""
    control_points = region.control_points
    half_planes = [cut for cut in deformation.cuts if isinstance(cut, HalfPlane)]
    surfaces = [cut for cut in deformation.cuts if isinstance(cut, Surface)]
    planes, index_planes = [], []
    for plane in deformation.planes:
        planes.append([*plane.normal, plane.height(control_points.centre) / control_points.scale])
        if grid is not None:
            by_index = plane.normal @ grid.index_to_world
            index_planes.append([*by_index, plane.height(grid.origin)])
    frames = np.array(
        [np.stack(half.frame(control_points.deformed), axis=1) for half in half_planes]
    )
    frames = (
        frames.reshape(len(half_planes), len(control_points), 3).swapaxes(0, 1)
        / control_points.scale
    )
    radius = np.hypot(frames[..., :1], frames[..., 1:2])
    ranges, triangles, edges = [], [], []
    for surface in surfaces:
        start = len(triangles), len(edges)
        corners = np.sort(surface.triangles, axis=1)
        triangles.extend(control_points.local(surface.points[corners]).reshape(-1, 9))
        edges.extend(control_points.local(surface.boundary).reshape(-1, 6))
        ranges.append([start[0], len(triangles), start[1], len(edges)])
    tables = {
        "planes": _table(planes),
        "index_planes": _table(index_planes),
        "sides": _table(region.sides),
        "half_planes": _table(
            [
                [*control_points.local(half.point), *half.normal, *half.inward, *half.along]
                for half in half_planes
            ]
        ),
        "frames": _table(np.concatenate([frames, radius], axis=2)),
        "surfaces": _table(ranges, np.int32),
        "triangles": _table(triangles),
        "edges": _table(edges),
    }
    constants = [("HALF_PLANES", len(half_planes)), ("SURFACES", int(bool(surfaces)))]
    return CutTables(constants, tables, len(surfaces))


def _table(rows, dtype=np.float32):
    """A buffer's content; OpenCL has no empty ones."""
    table = np.ascontiguousarray(rows, dtype=dtype).ravel()
    return table if table.size else np.zeros(1, dtype)
