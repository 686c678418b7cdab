"""Nodes of a coarse map, interpolated between nodes twice as far apart: sparse_node.cl."""

from __future__ import annotations

import numpy as np

from vtk_mls.engine.launch.structs import CONSTANTS
from vtk_mls.engine.map import nodes
from vtk_mls.engine.map.cells import Box, box_of, dilated, doubled, near_handles

_RATIO = 2
_COARSE_STEP = CONSTANTS["COARSE_STEP"]
STEP = _RATIO * _COARSE_STEP
# As that of the coarse map, and twice that, for errors of nodes add to those between them.
_SAFETY = 16
# Of the cells, with control points in or beside them. Ten times as many are inaccurate.
_MAX_NEAR_FRACTION = 0.03


class SparseMap:
    """The map of a region at nodes twice as far apart as those of a CoarseMap.

    It gives the map at the nodes of that one: interpolated in sparse cells that are accurate and
    not beside others, and evaluated elsewhere.

    Parameters
    ----------
    map_ : RegionMap
    """

    def __init__(self, map_):
        self.map = map_

    def pays_off(self, whole):
        """Whether few cells are near control points."""
        near = near_handles(self.map, whole, box_of(whole, STEP), STEP)
        return near.mean() < _MAX_NEAR_FRACTION

    def find(self, whole, box):
        """The map at nodes around a box of coarse cells, in their middles, and accurate ones.

        Three buffers: accurate cells, a byte each, need no check and have no middle.
        """
        map_ = self.map
        node_box = box.widened(nodes.BEFORE, nodes.AFTER)
        cells = Box(node_box.first // _RATIO, -(-node_box.stop // _RATIO))
        sparse_box, sparse_planes, *unsure = self._check(whole, cells)
        node_planes, middles = (
            nodes.node_buffer(map_, np.prod(inner.cells)) for inner in (node_box, box)
        )
        nodes.launch_cells(
            *(map_, "sparse_node", (None, False), cells.cells),
            *(cells.record(**nodes.around(sparse_box)), sparse_planes),
            *(box.record(**nodes.around(box)), node_planes),
        )
        every = cells.scaled(_RATIO)
        inaccurate, rough = (
            doubled(mask)[every.rows(inner)] for mask, inner in zip(unsure, (node_box, box))
        )
        tables = (0, node_box, node_planes, inaccurate), (_COARSE_STEP / 2, box, middles, rough)
        for offset, inner, table, evaluated in tables:
            grid = nodes.node_grid(whole, _COARSE_STEP, inner, offset)
            nodes.evaluate(map_, grid, np.flatnonzero(evaluated), table)
        return node_planes, middles, map_.memory.constant((~rough).view(np.uint8))

    def _check(self, whole, cells):
        """A larger box and the map around it, and which sparse cells are inaccurate and rough.

        Nodes in inaccurate cells are evaluated, and coarse cells in rough ones checked.
        """
        map_ = self.map
        checked = cells.widened(1, 1).within(box_of(whole, STEP))  # others are next to these
        box = Box(np.minimum(cells.first, checked.first), np.maximum(cells.stop, checked.stop))
        node_box = box.widened(nodes.BEFORE, nodes.AFTER)
        planes = nodes.evaluated(map_, nodes.node_grid(whole, STEP, node_box))
        middles = nodes.evaluated(map_, nodes.node_grid(whole, STEP, checked, STEP / 2))
        check = nodes.check_of(map_, whole, _SAFETY)
        flags = nodes.check_flags(map_, whole, checked, check, nodes.around(box), planes, middles)
        in_box = np.zeros(box.shape, np.uint8)
        in_box[box.rows(checked)] = flags
        near = near_handles(map_, whole, cells, STEP)
        rough = dilated(in_box & CONSTANTS["ROUGH"] != 0)
        inner = box.rows(cells)
        return box, planes, nodes.inaccurate(in_box)[inner] | near, rough[inner] | near
