"""Random datasets, control points, cuts and properties, each from a numpy Generator."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import (
    VTK_DOUBLE,
    VTK_FLOAT,
    VTK_INT,
    VTK_LONG_LONG,
    VTK_UNSIGNED_LONG_LONG,
    vtkPoints,
)
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAHEDRON,
    VTK_PIXEL,
    VTK_QUAD,
    VTK_VOXEL,
    vtkCellArray,
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPointSet,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersAMR import vtkAMRGaussianPulseSource
from vtkmodules.vtkFiltersSources import vtkCellTypeSource

from vtk_mls import CUT_FRAMES, INTERPOLATIONS, VOID_VALUES, HalfPlane, Plane, Surface
from vtk_mls.base.validation import short_repr
from vtk_mls.model.options import named
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of

CONSTANT = "constant"  # the name of an array
_CONSTANTS = (
    (VTK_INT, np.int32, 2**31 - 1),
    (VTK_LONG_LONG, np.int64, 2**62 + 1),
    (VTK_UNSIGNED_LONG_LONG, np.uint64, 2**53 + 1),
    (VTK_DOUBLE, np.float64, 4.5e6 + 0.3),
)
_CELL_TYPES = (3, 5, 7, 9, 10, 11, 12, 13, 14, 15, 16, 21, 22, 23, 24, 25, 26, 27, 28, 29)
_CURVED_TYPES = (35, 37, 68, 69, 70, 71, 72, 73, 75, 76, 77, 78, 79, 80)
_EMPTY_TYPES = (0, 2, 4, 5, 6, 7, 10)  # of cells without points
_FLAT_CELLS = ((1, 1), (2, 7), (3, 2), (4, 5), (5, 3), (6, 6), (7, 5), (9, 4), (10, 4), (12, 8))


class Scene:
    """Where everything is: a box of random place and size, and things in it."""

    def __init__(self, rng):
        self.rng = rng
        self.size = 10.0 ** rng.integers(-9, 10) if rng.random() < 0.3 else 1.0
        shift = rng.choice([0, 1, 1e3], p=[0.5, 0.4, 0.1])
        self.low = rng.normal(0, 1, 3) * self.size * shift

    def places(self, count, spread=1.0):
        """Some in the box, or as far round it as `spread` says."""
        return self.low + self.size * (0.5 + spread * self.rng.uniform(-0.5, 0.5, (count, 3)))

    def handles(self):
        rng = self.rng
        count = int(rng.choice([1, 2, 3, 5, 12, 40]))
        rest = self.places(count)
        if rng.random() < 0.2:  # on a plane or a line
            flat = rng.integers(1, 3)
            rest[:, :flat] = rest[0, :flat]
        deformed = rest + rng.normal(0, self.size * rng.choice([0, 0.03, 0.1, 0.5]), rest.shape)
        if rng.random() < 0.2:
            still = rng.random(count) < 0.7
            deformed[still] = rest[still]
        if rng.random() < 0.1:
            deformed[rng.integers(count)] = deformed[0]
        weights = rng.uniform(0.1, 10, count) if rng.random() < 0.2 else None
        return rest, deformed, weights

    def connected_handles(self):
        """How a filter gets control points, and these."""
        return str(self.rng.choice(["own", "polydata", "source"])), *self.handles()

    def surfaces(self):
        """Polygons to cut along, that hang together or not, and other cells, which are no cuts."""
        rng, mesh = self.rng, self.polydata()
        if rng.random() < 0.5:
            for drop in (mesh.SetVerts, mesh.SetLines, mesh.SetStrips):
                drop(vtkCellArray())
        return mesh

    def cut(self):
        rng = self.rng
        place, normal, inward = self.places(1)[0], rng.normal(size=3), rng.normal(size=3)
        if rng.random() < 0.3:
            normal = np.eye(3)[rng.integers(3)]
        kind = rng.choice(["plane", "half-plane", "polygon", "bent"])
        if kind == "plane":
            return Plane(place, normal)
        if kind == "half-plane":
            return HalfPlane(place, normal, inward)
        corners = self.places(4, 1.5)
        if kind == "polygon":
            return Surface.polygon(corners[:3])
        return Surface(corners, [(0, 1, 2), (1, 2, 3)])

    def dataset(self, may_be_composite=True):
        """Any that the filter takes."""
        rng = self.rng
        makers = [self.image, self.image, self.cells, self.cells, self.flat_cells, self.boxes]
        makers += [self.polydata, self.structured, self.rectilinear, self.point_set]
        if may_be_composite and rng.random() < 0.08:
            if rng.random() < 0.2:
                return output_of(vtkAMRGaussianPulseSource())  # of two levels: it is refused
            blocks = vtkMultiBlockDataSet()
            for number in range(rng.integers(0, 4)):
                block = None if rng.random() < 0.2 else self.dataset(False)
                blocks.SetBlock(number, block)
            return blocks
        data = makers[rng.integers(len(makers))]()
        if isinstance(data, vtkPointSet) and data.GetNumberOfPoints() and rng.random() < 0.15:
            spoilt = arrays.to_numpy(data.GetPoints().GetData()).copy()
            bad = rng.choice([np.nan, np.inf, 1e30, -1e12, 1e3])
            spoilt[rng.integers(len(spoilt)), rng.integers(3)] = bad
            self._set_places(data, spoilt)
        elif isinstance(data, vtkPointSet) and data.GetNumberOfPoints() and rng.random() < 0.1:
            self._set_integers(data)
        self._add_arrays(data)
        return data

    def image(self):
        rng, image = self.rng, vtkImageData()
        dimensions = rng.integers(1, 14, 3)
        start = rng.integers(-3, 4, 3) if rng.random() < 0.3 else np.zeros(3, int)
        image.SetExtent([int(i) for a, n in zip(start, dimensions) for i in (a, a + n - 1)])
        image.SetSpacing(*(self.size / np.maximum(dimensions - 1, 1)))
        image.SetOrigin(*self.low)
        if rng.random() < 0.3:
            turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            image.SetDirectionMatrix(*turn.ravel())
        return image

    def cells(self):
        rng = self.rng
        types = _CELL_TYPES if rng.random() < 0.7 else _CURVED_TYPES
        source = configured(vtkCellTypeSource(), CellType=int(rng.choice(types)))
        blocks = int(rng.integers(1, 4))
        mesh = output_of(source, BlocksDimensions=(blocks,) * 3)
        for data in (mesh.GetPointData(), mesh.GetCellData()):
            data.Initialize()
        x = arrays.to_numpy(mesh.GetPoints().GetData())
        self._set_places(mesh, self.low + self.size * x / blocks)
        return mesh

    def flat_cells(self):
        """Cells of any shape: many have no size, or are tangled."""
        rng, mesh = self.rng, vtkUnstructuredGrid()
        chosen = [_FLAT_CELLS[i] for i in rng.integers(0, len(_FLAT_CELLS), rng.integers(1, 6))]
        x = self.places(sum(count for _, count in chosen) + 2)
        x[:, : rng.integers(0, 3)] = x[0, 0]
        self._set_places(mesh, x)
        first = 0
        for kind, count in chosen:
            mesh.InsertNextCell(kind, count, list(range(first, first + count)))
            first += count
            if rng.random() < 0.1:
                mesh.InsertNextCell(int(rng.choice(_EMPTY_TYPES)), 0, [])
        return mesh

    def boxes(self):
        """Voxels and pixels side by side, now and then among hexahedra and quads."""
        rng, mesh = self.rng, vtkUnstructuredGrid()
        count = int(rng.integers(1, 6))
        nodes = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in range(count + 1)])
        self._set_places(mesh, self.low + self.size * nodes / [count, 1, 1])
        for i in range(count):
            row, layer = count + 1, 2 * (count + 1)
            corners = [i + a + b * row + c * layer for c in (0, 1) for b in (0, 1) for a in (0, 1)]
            free = [corners[k] for k in (0, 1, 3, 2, 4, 5, 7, 6)]
            kinds = VTK_VOXEL, VTK_PIXEL, VTK_HEXAHEDRON, VTK_QUAD
            kind = rng.choice(kinds, p=[0.5, 0.3, 0.1, 0.1])
            ids = corners if kind in (VTK_VOXEL, VTK_PIXEL) else free
            ids = ids if kind in (VTK_VOXEL, VTK_HEXAHEDRON) else ids[:4]
            mesh.InsertNextCell(int(kind), len(ids), ids)
        return mesh

    def polydata(self):
        rng, mesh = self.rng, vtkPolyData()
        count = int(rng.integers(0, 30))
        self._set_places(mesh, self.places(count))
        for add in (mesh.SetVerts, mesh.SetLines, mesh.SetPolys, mesh.SetStrips):
            least = {"SetVerts": 1, "SetLines": 2}.get(add.__name__, 3)
            if count > 6 and rng.random() < 0.6:
                cells = vtkCellArray()
                for _ in range(rng.integers(1, 5)):
                    size = int(rng.integers(least, 7))
                    size = 0 if rng.random() < 0.05 else size
                    cells.InsertNextCell(size, rng.permutation(count)[:size].tolist())
                add(cells)
        return mesh

    def structured(self):
        mesh, dimensions = vtkStructuredGrid(), self.rng.integers(1, 5, 3)
        mesh.SetDimensions(*dimensions.tolist())
        axes = [np.linspace(0, 1, n) for n in dimensions]
        z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
        x = np.stack([x, y, z + 0.1 * x * y], axis=-1).reshape(-1, 3)
        self._set_places(mesh, self.low + self.size * x)
        return mesh

    def rectilinear(self):
        mesh, dimensions = vtkRectilinearGrid(), self.rng.integers(1, 5, 3)
        mesh.SetDimensions(*dimensions.tolist())
        for axis, name in enumerate("XYZ"):
            t = np.sort(self.rng.uniform(0, 1, dimensions[axis]))
            values = arrays.from_numpy(self.low[axis] + self.size * t, VTK_DOUBLE)
            getattr(mesh, f"Set{name}Coordinates")(values)
        return mesh

    def point_set(self):
        mesh = vtkPointSet()
        self._set_places(mesh, self.places(int(self.rng.integers(0, 20)), 1.3))
        return mesh

    def _set_places(self, mesh, x):
        points, single = vtkPoints(), self.rng.random() < 0.4
        points.SetDataType(VTK_FLOAT if single else VTK_DOUBLE)
        with np.errstate(all="ignore"):
            x = np.ascontiguousarray(x, np.float32 if single else np.float64)
        points.SetData(arrays.from_numpy(x, points.GetDataType()))
        mesh.SetPoints(points)

    def _set_integers(self, mesh):
        """Make the places of a mesh integers, in a unit in which no two become one."""
        points = vtkPoints()
        points.SetDataType(int(self.rng.choice([VTK_INT, VTK_LONG_LONG])))
        for i in range(mesh.GetNumberOfPoints()):
            x = np.clip(np.array(mesh.GetPoint(i)) * 1000 / self.size, -1e9, 1e9)
            points.InsertNextPoint(*np.rint(x))
        mesh.SetPoints(points)

    def _add_arrays(self, data):
        """Numbers of several types; now and then too few of them."""
        rng = self.rng
        short = rng.random() < 0.03
        for attributes, count in (
            (data.GetPointData(), data.GetNumberOfPoints()),
            (data.GetCellData(), data.GetNumberOfCells()),
        ):
            for name in ("a", "b", "vectors"):
                if rng.random() < 0.4:
                    rows = max(0, count - 2) if short else count
                    shape = (rows, 3) if name == "vectors" else (rows,)
                    dtype = [np.float32, np.float64, np.uint8][rng.integers(3)]
                    arrays.add(attributes, name, rng.uniform(0, 200, shape).astype(dtype))
        if rng.random() < 0.3 and not short:
            vtk_type, dtype, value = _CONSTANTS[rng.integers(len(_CONSTANTS))]
            constant = np.full(data.GetNumberOfPoints(), value, dtype)
            array = configured(arrays.from_numpy(constant, vtk_type), Name=CONSTANT)
            data.GetPointData().AddArray(array)

    def properties(self):
        """Setters of `MLSDeform` with values; now and then one that is wrong."""
        rng, found = self.rng, {}
        choices = {
            "Kind": named("kind").choices,
            "Order": (0, 1, 2, 3),
            "Alpha": (0.5, 1.0, 1.3, 2.0, 3.0),
            "Degree": (1, 2, 3),
            "Nu": (1.1, 2.0, 3.0),
            "Blend": (0.0, 0.5, 1.0, -1.0, 2.0),
            "Interpolation": INTERPOLATIONS,
            "Background": (0.0, -3.5, 1e9),
            "AutomaticBackground": (False, True),
            "OutputGrid": ("input", "input", "fitted", "given"),
            "VoidValues": VOID_VALUES,
            "HideVoid": (True, False),
            "SplitCells": (True, False),
            "GenerateOverlap": (True, False),
            "GenerateJacobian": (True, False),
            "GenerateJacobianDeterminant": (True, False),
            "GenerateCellQuality": (True, False),
            "GenerateLargestBlend": (True, False),
            "SampleDimensions": ((4, 5, 6), (2, 1, 3)),
            "OutputDimensions": ((5, 4, 3), (1, 1, 1)),
            "OutputSpacing": (tuple([self.size / 4] * 3),),
            "OutputOrigin": (tuple(self.low.tolist()),),
            "CutType": ("none", "none", "plane", "half-plane"),
            "CutFrame": CUT_FRAMES,
            "CutOrigin": (tuple(self.places(1)[0].tolist()),),
            "CutNormal": ((1.0, 0.0, 0.0), (0.3, -1.0, 2.0)),
            "CutInward": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.2)),
        }
        wrong = ("Alpha", -1.0), ("Kind", "rigit"), ("Degree", 7), ("Nu", 0.5), ("Blend", np.nan)
        wrong += ("OutputGrid", "none"), ("CutNormal", (0, 0, 0)), ("Alpha", 10**400)
        wrong += (("CutFrame", "world"),)
        for name in rng.permutation(list(choices))[: rng.integers(1, 9)]:
            found[str(name)] = choices[name][rng.integers(len(choices[name]))]
        if rng.random() < 0.08:
            name, value = wrong[rng.integers(len(wrong))]
            found[name] = value
        return found


def properties_text(properties):
    """Properties on one line."""
    return ", ".join(f"{name} {short_repr(value)}" for name, value in sorted(properties.items()))
