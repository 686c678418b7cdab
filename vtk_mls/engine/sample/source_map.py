"""The map of a target grid to indices of the source, as kernels evaluate it."""

from __future__ import annotations

import numpy as np

from vtk_mls.engine.launch import array_types, kernel_arguments


class SourceMap:
    """The map of the points of a target grid to continuous indices of the source.

    `maps` are the RegionMaps to launch on a grid, and whether it is the second pass; `competing` a
    buffer for void distances, if competing regions need it to choose.
    """

    def __init__(self, memory, maps, sampling, competing):
        self.memory, self.target, self.competing = memory, sampling.target, competing
        self._launches = [
            (map_, kernel_arguments.to_source(sampling, map_.control_points), second_pass)
            for map_, second_pass in maps
        ]

    def find(self, part, index, distance):
        """Write the indices of the points `part` of the target into a buffer, in planes.

        And their void distances into the buffer `distance`, unless it is None.
        """
        self._launch("grid_source_index", part, index, distance)

    def transform(self, vectors, part, index, distance, result):
        """As `find`, and fill `result` (m, 3) with the covariant vectors at `part` of a Sampler."""
        count = part.stop - part.start
        if not vectors.fits:
            self.find(part, index, distance)
        for piece in vectors.pieces(index, count):
            if piece.stop - piece.first < count:  # `find` has filled the buffers of the part
                index = self.memory.scratch("sources of a piece", 12 * count)
                distance = self.competing
            points = slice(part.start + piece.first, part.start + piece.stop)
            with self.memory.output_buffer(result[piece.first : piece.stop]) as out:
                self._launch(
                    *("grid_covariant", points, index, distance, vectors.record(piece)),
                    *(np.int32(bool(vectors.rule.covariant)), piece.values, out),
                    constants=(array_types.offset(vectors.array), vectors.taps),
                )

    def _launch(self, kernel, part, index, distance, *arguments, constants=()):
        for map_, to_source, second_pass in self._launches:
            outputs = [index, *map_.void_outputs(distance), *arguments]
            map_.launch_on_grid(
                *(kernel, self.target, part, to_source, *outputs),
                second_pass=second_pass,
                coarsely=True,
                constants=constants,
            )
