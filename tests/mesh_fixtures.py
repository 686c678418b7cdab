"""Meshes of every type, cuts through them, and what tests ask of them. Tests import them."""

import numpy as np
import pytest
from handle_surfaces import carried
from pipelines import connect, control_points
from vtk_fixtures import DEFORMED, FAST, REST, add_array
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_FLOAT, vtkIdList
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAHEDRON,
    VTK_LINE,
    VTK_POLYHEDRON,
    VTK_PYRAMID,
    VTK_QUAD,
    VTK_QUADRATIC_HEXAHEDRON,
    VTK_QUADRATIC_TETRA,
    VTK_TETRA,
    VTK_TRIANGLE,
    VTK_VOXEL,
    VTK_WEDGE,
    vtkExplicitStructuredGrid,
    vtkPointSet,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkFiltersCore import vtkAppendFilter
from vtkmodules.vtkFiltersSources import vtkCellTypeSource, vtkSphereSource
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter, vtkMeshQuality

from vtk_mls import Deformation, HalfPlane, Plane, Surface
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk import arrays, splitting
from vtk_mls.vtk.cells import append_meshes, set_positions
from vtk_mls.vtk.cells import positions_of as places_of
from vtk_mls.vtk.objects import configured, output_of
from vtk_mls.vtk.orientation import inverted

LOW, HIGH = np.array([0.6, 0.4, 0.2]), np.array([7.4, 7.1, 5.9])
LINEAR = [VTK_TETRA, VTK_HEXAHEDRON, VTK_WEDGE, VTK_PYRAMID, VTK_VOXEL]
QUADRATIC = [VTK_QUADRATIC_TETRA, VTK_QUADRATIC_HEXAHEDRON]
CUTS = {
    "plane": Plane((4.03, 4, 3), (1, 0.2, 0.1)),
    "half-plane": HalfPlane((4.03, 4, 3.1), (1, 0.2, 0.1), (0, 0, 1)),
    "polygon": Surface.polygon([(4.03, 2, 1), (4.1, 6.1, 1), (4.1, 6.1, 5), (4.03, 2, 5)]),
    "tent": Surface(
        [(4, 0, 0), (4, 8, 0), (5, 0, 4), (5, 8, 4), (4, 0, 9), (4, 8, 9)],
        [(0, 1, 2), (1, 3, 2), (2, 3, 4), (3, 5, 4)],
    ),
}


def reference(cuts=(), **options):
    return Deformation(REST, DEFORMED, cuts=cuts, device="reference", **options)


def set_places(mesh, places, vtk_type=VTK_DOUBLE):
    set_positions(mesh, np.array(places), vtk_type)


def decorated(mesh):
    """With a linear function on the points, the number of each cell, and strings."""
    if mesh.GetNumberOfPoints():
        x = np.array([mesh.GetPoint(i) for i in range(mesh.GetNumberOfPoints())])
        add_array(mesh.GetPointData(), "linear", linear(x))
    add_array(mesh.GetCellData(), "number", np.arange(mesh.GetNumberOfCells()))
    names = [str(i) for i in range(mesh.GetNumberOfPoints())]
    arrays.add_texts(mesh.GetPointData(), "names", names)
    add_array(mesh.GetFieldData(), "time", [2.5])
    return mesh


def grid_of(places, cells):
    """A vtkUnstructuredGrid of points (n, 3), and of cells by their types and ids."""
    grid = vtkUnstructuredGrid()
    set_places(grid, places)
    for kind, ids in cells:
        grid.InsertNextCell(kind, len(ids), list(ids))
    return grid


def split(mesh, cuts):
    """The divided mesh, and from each point to a place on its side."""
    output, to_cut, side = splitting.split(mesh, cuts)
    return output, to_cut + 1e-5 * np.max(HIGH - LOW) * side


def linear(x):
    return x @ [1.0, -2.0, 0.5] + 3


def cells(cell_type, blocks=4, vtk_type=VTK_DOUBLE):
    """Cells of one type that fill the box."""
    if cell_type == VTK_POLYHEDRON:
        return polyhedra(blocks)
    source = configured(vtkCellTypeSource(), CellType=cell_type)
    source.SetBlocksDimensions(blocks, blocks, blocks)
    mesh = output_of(source)
    for data in (mesh.GetPointData(), mesh.GetCellData()):
        data.Initialize()
    set_places(mesh, LOW + places_of(mesh) / blocks * (HIGH - LOW), vtk_type)
    return decorated(mesh)


def polyhedra(blocks):
    """Hexahedra, told by their faces."""
    hexahedra = cells(VTK_HEXAHEDRON, blocks)
    mesh = vtkUnstructuredGrid()
    mesh.SetPoints(hexahedra.GetPoints())
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    for number in range(hexahedra.GetNumberOfCells()):
        corners, stream = hexahedra.GetCell(number).GetPointIds(), vtkIdList()
        stream.InsertNextId(len(faces))
        for face in faces:
            stream.InsertNextId(4)
            for corner in face:
                stream.InsertNextId(corners.GetId(corner))
        mesh.InsertNextCell(VTK_POLYHEDRON, stream)
    return decorated(mesh)


def mixed():
    append = vtkAppendFilter()
    for shift, kind in enumerate([VTK_TETRA, VTK_LINE, VTK_QUADRATIC_TETRA, VTK_TRIANGLE]):
        source, transform = configured(vtkCellTypeSource(), CellType=kind), vtkTransform()
        source.SetBlocksDimensions(2, 2, 2)
        transform.Translate(1.5 * shift, shift, 1)
        append.AddInputData(carried(output_of(source), transform))
    return decorated(output_of(append))


def sphere():
    source = configured(vtkSphereSource(), Center=(4, 4, 3), Radius=2.4, OutputPointsPrecision=1)
    return decorated(output_of(source, ThetaResolution=40, PhiResolution=30))


def structured():
    mesh = vtkStructuredGrid()
    mesh.SetExtent(2, 6, 0, 5, -1, 3)
    z, y, x = np.meshgrid(
        *(np.linspace(a, b, n) for a, b, n in zip(LOW[::-1], HIGH[::-1], (5, 6, 5))), indexing="ij"
    )
    set_places(mesh, np.stack([x, y, z + 0.05 * x * y], axis=-1).reshape(-1, 3))
    return decorated(mesh)


def rectilinear():
    mesh = vtkRectilinearGrid()
    mesh.SetExtent(2, 6, 0, 5, -1, 3)
    for axis, name in enumerate("XYZ"):
        t = np.linspace(0, 1, (5, 6, 5)[axis]) ** 1.3
        values = arrays.from_numpy(LOW[axis] + t * (HIGH - LOW)[axis], VTK_DOUBLE)
        getattr(mesh, f"Set{name}Coordinates")(values)
    return decorated(mesh)


def explicit_structured():
    grid = cells(VTK_HEXAHEDRON, 3)
    mesh = vtkExplicitStructuredGrid()
    mesh.SetExtent(0, 3, 0, 3, 0, 3)
    mesh.SetPoints(grid.GetPoints())
    mesh.SetCells(grid.GetCells())
    return decorated(mesh)


def point_set():
    mesh = vtkPointSet()
    set_places(mesh, np.random.default_rng(1).uniform(LOW, HIGH, (50, 3)))
    return decorated(mesh)


MESHES = {
    **{f"cells {kind}": lambda kind=kind: cells(kind) for kind in [*LINEAR, *QUADRATIC]},
    "single precision": lambda: cells(VTK_TETRA, vtk_type=VTK_FLOAT),
    "polyhedra": lambda: polyhedra(3),
    "mixed": mixed,
    "polydata": sphere,
    "structured": structured,
    "rectilinear": rectilinear,
    "explicit structured": explicit_structured,
    "points": point_set,
}
VOLUMES = [name for name in MESHES if name not in ("mixed", "polydata", "points")]


@pytest.fixture(params=MESHES)
def any_mesh(request):
    return MESHES[request.param]()


def deforming(mesh, handles=None, device=FAST, cut=None, kind=MLSDeform, **properties):
    filter_ = connect(kind(), mesh, handles or control_points())
    filter_.SetDevice(device)
    if cut is not None:
        filter_.AddCut(cut)
    return configured(filter_, **properties)


def array_of(dataset, name, data="Point"):
    return arrays.to_numpy(getattr(dataset, f"Get{data}Data")().GetArray(name))


def scaled_jacobians_of(mesh):
    """The quality of cells, by VTK."""
    quality = configured(vtkMeshQuality(), InputData=mesh)
    for name in ("Triangle", "Quad", "Tet", "Hex", "Wedge", "Pyramid"):
        getattr(quality, f"Set{name}QualityMeasureToScaledJacobian")()
    return array_of(output_of(quality), "Quality", "Cell")


def count(dataset, name):
    return dataset.GetFieldData().GetArray(name).GetValue(0)


def count_inverted(*arguments):
    """The number of cells that are inside out, and of those that cannot be checked."""
    is_inverted, unchecked = inverted(*arguments)
    return np.count_nonzero(is_inverted), unchecked


def as_grid(mesh):
    return append_meshes([mesh])


def sizes(mesh):
    """Signed size of each cell of the highest dimension."""
    data = output_of(vtkCellSizeFilter(), InputData=mesh).GetCellData()
    volumes = arrays.to_numpy(data.GetArray("Volume"))
    return volumes if volumes.any() else arrays.to_numpy(data.GetArray("Area"))


OPENED = DEFORMED + np.where(REST[:, :1] > 4, [[1.2, 0, 0]], [[-1.2, 0, 0]])


# Two control points in the middle that are pushed past each other, between eight that rest.
PINCHED = np.r_[REST, [(3.4, 4, 3), (4.6, 4, 3)]]
# The same between four in a plane.
FLAT_PINCHED = np.array([(1, 1, 3), (7, 1, 3), (7, 7, 3), (1, 7, 3), (3.4, 4, 3), (4.6, 4, 3.0)])


def pinch(push):
    moved = PINCHED.copy()
    moved[-2:, 0] += (push, -push)
    return control_points(PINCHED, moved)


def plate(side=20):
    """Quads in the plane z = 3."""
    t = np.linspace(1, 7, side + 1)
    first = np.add.outer((side + 1) * np.arange(side), np.arange(side)).ravel()
    quads = first[:, None] + (0, 1, side + 2, side + 1)
    return grid_of([(a, b, 3.0) for b in t for a in t], [(VTK_QUAD, ids) for ids in quads.tolist()])
