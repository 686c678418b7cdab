"""A mesh that is drawn deformed; with many points, by an interpolated map while the mouse drags."""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersHybrid import vtkGridTransform
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkPolyDataMapper

from vtk_mls import Deformation
from vtk_mls.base.interpolation import sample
from vtk_mls.filters.algorithm import Algorithm, CachedValue
from vtk_mls.filters.warping import stamps
from vtk_mls.queries import inverses
from vtk_mls.queries.vector_fields import covariant
from vtk_mls.queries.void_cells import over_corners
from vtk_mls.rendering.rest_surface import RestSurface, determinants, jacobians, state_of
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of
from vtk_mls.vtk.splitting import height_function

# Largest mesh for which the map itself is as fast as its interpolation; nodes of the grid.
MAX_EXACT_POINTS, _NODES = 1 << 18, 1 << 18
_MAX_ERROR = 5e-4  # as a fraction of the grid's largest side: half a pixel of 1000
# Subclasses of vtkPolyDataMapper for composite data.
_COMPOSITE = "vtkCompositePolyDataMapper", "vtkCompositePolyDataMapper2"


class DeformedMesh:
    """Draws the mesh of an actor deformed.

    A `MeshDeformer` is inserted into VTK's pipeline before the actor's mapper. It outputs the
    surface of the mesh, with points moved by the exact inverse of the backward map as in
    `MLSDeform`, cells split along cuts, and normals transformed. The mesh itself is not changed. A
    change of the mesh, of the mapper's input or of the actor's mapper shows in the next picture.

    Parameters
    ----------
    actor : vtkActor
        With a vtkPolyDataMapper or a vtkDataSetMapper. The deformation is in the coordinates of
        the mesh; the transformation of the actor is applied after it.

    Raises
    ------
    TypeError, ValueError
        For another mapper, or an actor whose mesh is drawn deformed already.
    """

    def __init__(self, actor: vtkActor) -> None:
        mapper = actor.GetMapper()
        if not _is_mesh_mapper(mapper):
            got = "none" if mapper is None else mapper.GetClassName()
            raise TypeError(
                "`actor` must have a vtkPolyDataMapper or a vtkDataSetMapper, "
                f"got {got}; of composite data give each block an actor of its own"
            )
        if _is_moved(mapper):
            raise ValueError("`actor` shows a deformed mesh already; update or detach that one")
        self._actor, self._deformer = actor, MeshDeformer()
        self._mapper, self._observers = None, {}  # tags by what is observed

    def update(
        self, deformation: Deformation, exact: bool = True, has_distortion: bool = False
    ) -> None:
        """Draw the mesh deformed by `deformation` from the next Render on.

        Parameters
        ----------
        deformation : Deformation
        exact : bool
            False while the mouse drags: a mesh with more than 262144 points is then moved by a map
            that is interpolated between some 64 x 64 x 64 points, with an error of at most about
            1/2000 of the mesh's size. Smaller meshes and points at cuts are always exact.
        has_distortion : bool
            Whether the drawn mesh has the point arrays "RestPosition", x of the undeformed space,
            and "JacobianDeterminant", det J_G, which is not positive where space folds.

        Raises
        ------
        TypeError, ValueError, DeviceError, MemoryError
            The drawn mesh stays as it was.
        """
        if not isinstance(deformation, Deformation):
            raise TypeError(f"`deformation` must be a Deformation, got {deformation!r}")
        if not self._observers:
            self._observe(self._actor)
        self._follow()
        self._deformer.deform(deformation, exact, has_distortion)

    def detach(self) -> None:
        """Draw the undeformed mesh; an update deforms it again."""
        for observed, tag in self._observers.items():
            observed.RemoveObserver(tag)
        self._observers.clear()
        self._leave()

    def _observe(self, subject):
        self._observers[subject] = subject.AddObserver("ModifiedEvent", self._follow)

    def _follow(self, *_):
        """Connect the deformer between the actor's mapper and the mapper's input."""
        if not vars(self):  # cleared by Python's garbage collector before the actor is deleted
            return
        mapper = self._actor.GetMapper()
        if mapper is not self._mapper:
            self._leave()
        if not _is_mesh_mapper(mapper):
            return
        if mapper is not self._mapper:
            self._mapper = mapper
            self._observe(mapper)
        if mapper.GetNumberOfInputConnections(0) > 0 and not _is_moved(mapper):
            self._deformer.SetInputConnection(0, mapper.GetInputConnection(0, 0))
            mapper.SetInputConnection(0, self._deformer.GetOutputPort())

    def _leave(self):
        """Reconnect the mapper to its own input."""
        mapper, self._mapper = self._mapper, None
        if mapper in self._observers:
            mapper.RemoveObserver(self._observers.pop(mapper))
        if mapper is not None and _producer(mapper) is self._deformer:
            mapper.SetInputConnection(0, self._deformer.GetInputConnection(0, 0))
        self._deformer.RemoveAllInputConnections(0)


class MeshDeformer(Algorithm):
    """A pipeline stage whose output is the deformed surface of its input.

    The split surface at rest depends on the mesh and the cuts only, and is cached.
    """

    def __init__(self):
        super().__init__()
        self._request = None, True, False  # as of `_polydata`
        self._rest_surface, self._coarse_map = CachedValue(), CachedValue()
        self._output = CachedValue()

    def deform(self, deformation, exact, has_distortion=False):
        """Set the Deformation, and update the output; unchanged after an error."""
        request = deformation, exact, has_distortion
        has_input = self.GetNumberOfInputConnections(0) > 0
        if has_input:
            self._polydata(self._update_input(0), *request)
        self._request = request
        self.Modified()
        if has_input:  # static mappers do not update it
            self.Update()

    def RequestData(self, request, inInfo, outInfo):
        mesh, output = vtkDataSet.GetData(inInfo[0]), vtkPolyData.GetData(outInfo)
        output.ShallowCopy(self._polydata(mesh, *self._request))
        output.GetFieldData().ShallowCopy(mesh.GetFieldData())
        return 1

    def _polydata(self, mesh, deformation, exact, has_distortion):
        cuts = () if deformation is None else deformation.cuts
        state = stamps(mesh), state_of(cuts)
        surface = self._rest_surface.of(state, lambda: RestSurface(mesh, cuts))
        count = len(surface.positions)
        if deformation is None or count == 0:
            return surface.surface
        # with cuts in the deformed frame the forward map is not smooth
        is_smooth = deformation.in_rest_frame or not cuts
        is_coarse = not exact and count > MAX_EXACT_POINTS and is_smooth

        def moved():
            mover = surface
            if is_coarse:
                mover = self._coarse_map.of(surface, lambda: CoarseForward(surface, cuts))
            return mover.moved(deformation, has_distortion)

        with np.errstate(all="ignore"):  # points may be NaN or far away
            return self._output.of((surface, deformation, is_coarse, has_distortion), moved)


def _is_mesh_mapper(mapper):
    """Whether a mapper draws a single mesh."""
    is_composite = mapper is not None and any(mapper.IsA(name) for name in _COMPOSITE)
    return isinstance(mapper, (vtkPolyDataMapper, vtkDataSetMapper)) and not is_composite


def _is_moved(mapper):
    return isinstance(_producer(mapper), MeshDeformer)


def _producer(mapper):
    if mapper.GetNumberOfInputConnections(0) == 0:
        return None
    return mapper.GetInputConnection(0, 0).GetProducer()


class CoarseForward:
    """Deforms a RestSurface by a forward map that is linear in each cell of a grid.

    The exact map is used in cells with too large an error, with a cut in the rest frame, or with a
    corner without an inverse; and for outliers beyond the grid.
    """

    def __init__(self, surface, cuts):
        self._surface = surface
        x = surface.positions
        self._grid = inverses.cubic_grid(inverses.usual_bounds(x, inverses.bounds(x)), _NODES)
        self._nodes = self._grid.points()
        self._last = np.array(self._grid.dimensions) - 1
        self._cell = _cells(self._grid, x)
        self._is_crossed = np.append(_crossed(self._grid, cuts), True)  # the last: outside
        self._rest = configured(vtkPolyData(), Points=surface.surface.GetPoints())
        self._rest.GetPointData().SetNormals(surface.surface.GetPointData().GetNormals())

    def moved(self, deformation, has_distortion=False):
        """The deformed surface as vtkPolyData, with arrays as of `RestSurface.moved`."""
        field = deformation.forward_field(self._nodes)
        moved = self._interpolated(field.displacement)
        points, normals = moved.GetPoints(), moved.GetPointData().GetNormals()
        rows = np.flatnonzero(self._is_exact(field)[self._cell])
        values = self._determinants(field) if has_distortion else None
        if len(rows) > 0:
            self._move_exactly(deformation, rows, points, normals, values)
        output = self._surface.with_points(points, normals)
        if has_distortion:
            self._surface.add_distortion(output, values)
        return output

    def _determinants(self, field):
        """det J_G at the points, from differences between the nodes: (n,) float32."""
        values = field.displacement.reshape(*self._grid.shape, 3)
        slopes = [np.gradient(values, h, axis=2 - i) for i, h in enumerate(self._grid.spacing)]
        forward = np.linalg.det(np.eye(3) + np.stack(slopes, axis=-1))
        with np.errstate(divide="ignore"):
            nodes = np.where(field.found.reshape(forward.shape), 1 / forward, 0)
        index = self._grid.index_of(self._surface.positions)
        return sample(nodes.astype(np.float32), index, "linear", 1.0, self._grid)

    def _interpolated(self, displacement):
        """The points and normals, moved by displacements of the nodes (m, 3)."""
        image = arrays.ImageGeometry.of_grid(self._grid).apply_to(vtkImageData())
        image.GetPointData().SetScalars(arrays.from_numpy(displacement, VTK_FLOAT))
        transform = configured(vtkGridTransform(), DisplacementGridData=image)
        return output_of(vtkTransformFilter(), Transform=transform, InputData=self._rest)

    def _is_exact(self, field):
        """Cells that need the exact map, judged by the map at the nodes.

        The last entry stands for points outside all cells. The error of linear interpolation is an
        eighth of the second difference.
        """
        values = field.displacement.reshape(*self._grid.shape, 3)
        error = np.zeros(self._grid.shape, np.float32)
        for axis in range(3):
            if values.shape[axis] > 2:
                second = np.abs(np.diff(values, 2, axis)).max(axis=-1) / 8
                ends = [(1, 1) if other == axis else (0, 0) for other in range(3)]
                error += np.pad(second, ends, "edge")
        allowed = _MAX_ERROR * (self._grid.spacing * self._last).max()
        wrong = ~(field.found.reshape(error.shape) & (error <= allowed))
        return self._is_crossed | np.append(over_corners(np.logical_or, wrong), True)

    def _move_exactly(self, deformation, rows, points, normals, values):
        """Set points, normals and determinants, if any, of some rows by the exact map."""
        surface, material = self._surface, self._surface.material(deformation)[rows]
        before = surface.positions[rows]
        field = deformation.forward_field(material)
        positions = before + field.displacement
        arrays.to_numpy(points.GetData())[rows] = positions
        if values is not None:
            parts = jacobians(deformation, positions, before, material)
            values[rows] = determinants(parts, field.found)
        if normals is None:
            return
        exact = arrays.to_numpy(surface.surface.GetPointData().GetNormals())[rows]
        for part, jacobian in jacobians(deformation, positions, before, material):
            exact[part] = covariant(exact[part], jacobian.swapaxes(1, 2), True)
        arrays.to_numpy(normals)[rows] = exact


def _cells(grid, points):
    """Ids of the cells that contain `points` (n, 3), -1 outside: (n,)."""
    last = np.array(grid.dimensions) - 1
    index = grid.index_of(points)
    inside = ((index >= 0) & (index <= last)).all(axis=1)
    i, j, k = np.minimum(np.where(inside[:, None], index, 0).astype(np.int32), last - 1).T
    return np.where(inside, i + last[0] * (j + last[1] * k), -1)


def _crossed(grid, cuts):
    """Which cells of a grid a cut crosses or nearly touches: (n,) bool."""
    cells = grid.part((0, 0, 0), np.array(grid.dimensions) - 1)
    radius = 0.51 * np.linalg.norm(grid.spacing)
    crossed = np.zeros(cells.size, bool)
    if not cuts:
        return crossed
    centers = cells.points() + grid.spacing / 2
    for cut in cuts:
        low, high = cut.bounds
        near = ((centers > low - radius) & (centers < high + radius)).all(axis=1) & ~crossed
        rows = np.flatnonzero(near)
        rows = rows[np.abs(height_function(cut)(centers[rows])) < radius]
        if cut.plane is not None:  # the height function continues beyond the edge
            rows = rows[cut.void_distance(centers[rows], centers[rows]) < radius]
        crossed[rows] = True
    return crossed
