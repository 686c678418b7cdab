"""The map of a grid, interpolated between nodes where that is accurate: coarse_map.cl."""

import numpy as np

from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, filled
from vtk_mls.engine.map import nodes
from vtk_mls.engine.map.nodes import Box, ListedCells, box_of, near_handles
from vtk_mls.queries.void_cells import largest_of_neighbors

STEP = CONSTANTS["COARSE_STEP"]
# Cells count as accurate if the error in their middle is at most an eighth of the tolerance, and
# those in the middles of their neighbors at most a quarter. In 64,000 random cases, many of points
# that are mirrored or near a line, 11 errors were larger than the tolerance, by up to a fifth, and
# one where the map has a jump.
_SAFETY = 8
MAX_NODE_FRACTION = 0.25  # nodes and cell centers per point of the grid
MAX_NEAR_FRACTION = 0.5  # of the cells, with control points in or beside them
# The kernel that interpolates the outputs of another one.
_COARSE = {"grid_displacement": "coarse_displacement", "grid_source_index": "coarse_source_index"}


class CoarseMap:
    """The map of a region at nodes over a grid, and the cells that are interpolated accurately.

    Nodes and cells are those of the whole grid, and some beyond its end, so parts find the same.
    Its RegionMap, `map_`, owns it.
    """

    def __init__(self):
        self._grid = None
        self._pays_off = {}  # by whole grid

    def pays_off(self, map_, grid):
        """Whether a grid has far fewer nodes, and cells near control points, than points."""
        whole = grid.whole
        if whole not in self._pays_off:
            cells = box_of(whole, STEP).cells
            nodes_and_centers = np.prod(cells + 5.0) + np.prod(cells)
            has_few_nodes = nodes_and_centers / whole.size < MAX_NODE_FRACTION
            self._pays_off[whole] = has_few_nodes and _has_few_near_cells(map_, whole)
        return self._pays_off[whole]

    def launch(self, map_, name, grid, part, *arguments, constants=()):
        """Launch a kernel for the points `part` of a grid.

        It computes the points of inaccurate cells, after another kernel has interpolated those of
        all cells. Both take the `arguments`.
        """
        if grid is not self._grid:
            self._find(map_, grid)
            self._grid = grid
        points = kernel_arguments.grid_points(grid, part, map_.control_points)
        own = box_of(grid, STEP)
        nx, ny, _ = grid.dimensions
        low, high = ((grid.first[2] + n // (nx * ny)) // STEP for n in (part.start, part.stop - 1))
        grid_and_pass = (grid.whole, False)
        box = Box([*own.first[:2], low], [*own.stop[:2], high + 1])
        to_local = grid.index_to_world / map_.control_points.scale
        to_slopes = kernel_arguments.transform(np.linalg.inv(to_local).T, np.zeros(3))
        record = box.record(**self._around, to_slopes=to_slopes)
        nodes.launch_cells(
            *(map_, _COARSE[name], grid_and_pass, box.cells, points, record),
            *(self._nodes, *arguments),
            constants=constants,
        )
        layers, _, _ = own.rows(box)
        for record in self._inaccurate.records(layers):
            items = map_.grid_items(grid, part, record, self._inaccurate.buffer)
            count = int(record["listed"]) * STEP**3
            map_.launch(
                *(name, grid_and_pass, count, points, *items, *arguments),
                constants=(*constants, ("POINTS", "CELLS")),
            )

    def _find(self, map_, grid):
        """Find the nodes around a grid, and its inaccurate cells."""
        whole, own = grid.whole, box_of(grid, STEP)
        box = own.widened(1, 1).within(box_of(whole, STEP))  # neighbors are checked, too
        node_box = box.widened(nodes.BEFORE, nodes.AFTER)
        self._around = {"first_node": box.first, "nodes": node_box.cells}
        self._nodes = nodes.evaluated(map_, nodes.node_grid(whole, STEP, node_box), whole.spacing)
        middles = nodes.node_grid(whole, STEP, box, STEP / 2)
        middles = nodes.evaluated(map_, middles, whole.spacing)
        points = kernel_arguments.grid_points(grid, slice(0, grid.size), map_.control_points)
        to_index = grid.world_to_index * map_.control_points.scale
        to_index = kernel_arguments.transform(to_index, np.zeros(3))
        limit = map_.deformation.map_tolerance / _SAFETY
        check = filled("check_t", to_index=to_index, limit2=limit**2)
        flags = np.zeros(box.shape, np.uint8)
        with map_.memory.output_buffer(flags) as out:
            nodes.launch_cells(
                *(map_, "coarse_check", (whole, False), box.cells, points),
                *(box.record(**self._around), check, self._nodes, middles, out),
            )
        is_inaccurate, spreads, is_elsewhere = (
            flags & CONSTANTS[name] != 0 for name in ("INACCURATE", "SPREADS", "OTHER_REGION")
        )
        is_inaccurate |= largest_of_neighbors(spreads)
        if map_.control_points.kind.has_peaks:
            is_inaccurate |= near_handles(map_, whole, box, STEP)
        inaccurate = (is_inaccurate & ~is_elsewhere)[box.rows(own)]
        self._inaccurate = ListedCells(map_.memory, own, inaccurate)


def _has_few_near_cells(map_, whole):
    if not map_.control_points.kind.has_peaks:
        return True
    handles = map_.control_points.handles
    count = len(handles) if len(handles.segments) == 0 else np.inf
    bound = 27 * count / np.prod(box_of(whole, STEP).cells)
    if bound < MAX_NEAR_FRACTION:
        return True
    return near_handles(map_, whole, box_of(whole, STEP), STEP).mean() < MAX_NEAR_FRACTION
