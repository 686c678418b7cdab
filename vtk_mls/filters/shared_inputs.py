"""Control points and cuts of all processes of a parallel program."""

from __future__ import annotations

from vtk_mls.filters import parallel, pipeline
from vtk_mls.vtk.control_point_polydata import as_polydata

# Ports: control points, cuts, mask, deformed control points.
_PORTS = 1, 2, 3, 4
_POINT_SETS = 1, 4
_SHARED = 1, 2, 4


class SharedInputs:
    """An algorithm that needs control points and cuts, ports 1, 2 and 4, of all processes."""

    _collected = None  # state of these ports when processes shared them, and the data

    def _collect(self, info=None):
        """Data on the shared ports, from all processes.

        All processes must call this at the same times, in RequestInformation and in
        RequestUpdateExtent. They communicate only after a change upstream, which all see.
        """
        counts = {port: self.GetNumberOfInputConnections(port) for port in _SHARED}
        connections = [(port, index) for port in counts for index in range(counts[port])]
        state = self._upstream(connections, info)
        if not connections:
            self._collected = None
        if not connections or (self._collected is not None and self._collected[0] == state):
            return

        def update():
            return [
                as_polydata(data) if port in _POINT_SETS else data
                for port, index in connections
                for data in [self._update_input(port, index, state[-1])]
            ]

        try:
            data = dict(zip(connections, parallel.gather_polydata(update)))
        except ValueError as error:
            data = error
        self._collected = state, data

    def _upstream(self, connections, info):
        """Connections, the pipeline's modification time of each, and the requested time."""
        changes = [self.GetInputExecutive(*pair).GetPipelineMTime() for pair in connections]
        return connections, changes, pipeline.requested_time(info)

    def _control_data(self, make_inputs):
        """Lists of the data on ports 1 to 4; `make_inputs(port)` gives those of this process."""
        if not parallel.is_parallel() or self._collected is None:
            return [make_inputs(port) for port in _PORTS]
        data = self._collected[1]
        if isinstance(data, ValueError):
            raise data
        return [
            [item for (shared_port, _), item in data.items() if shared_port == port]
            if port in _SHARED
            else make_inputs(port)
            for port in _PORTS
        ]
