"""Images and meshes for tests of files, and their oracles."""

import gzip
import struct

import nibabel
import numpy as np
import pytest
import SimpleITK
from pipelines import update
from vtk_fixtures import DEFORMED, REST, TURNED, add_scalars, make_image
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkStructuredGrid
from vtkmodules.vtkFiltersSources import vtkCellTypeSource, vtkSphereSource

from vtk_mls import io
from vtk_mls.files import frames
from vtk_mls.filters import MLSDisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.cells import set_positions
from vtk_mls.vtk.objects import configured, output_of

IMAGES = (".nii.gz", ".nii", ".nrrd", ".nhdr", ".mha", ".mhd")
RIGHT, LEFT = TURNED, TURNED * [1, 1, -1]
DIRECTIONS = {"right-handed": TURNED, "left-handed": TURNED * [1, -1, 1]}
ORIGIN, SPACING = np.array([19.25, -34.5, 45.125]), np.array([0.75, 1.5, 2.25])
VALUES = np.arange(7 * 8 * 9, dtype=np.int16).reshape(7, 8, 9) * 17 % 991
SMALL = np.arange(7 * 6 * 5, dtype="<i2").reshape(7, 6, 5)  # z, y, x
HANDLES = ORIGIN + [(2, 3, 4), (8, 1, 5), (3, 9, 2), (6, 6, 12)]
DRAGGED = HANDLES + [(1.5, 0, 0), (0, -1, 0.5), (0, 0, 0), (0.25, 0.5, -2)]
VECTORS = np.stack([VALUES, -VALUES, VALUES + 7.5], axis=-1).astype(np.float32)
META = """ObjectType = Image
NDims = 3
DimSize = 9 8 7
ElementType = MET_SHORT
Offset = 1 2 3
ElementSpacing = 2 3 4
AnatomicalOrientation = RAI
"""
COLORS = (np.arange(7 * 8 * 9 * 4) % 251).astype(np.uint8).reshape(7, 8, 9, 4)
NRRD = """NRRD0004
# a comment: with a colon
type: short
dimension: 3
space: left-anterior-superior
sizes: 2 2 1
space directions: (0,2,0) (-3,0,0) (0,0,4)
kinds: domain domain domain
endian: little
encoding: raw
space origin: (5,6,7)
key:=value
"""
NRRD_DATA = struct.pack("<4h", 1, 2, 3, 400)


def image_with(values, vtk_type, **place):
    return add_scalars(make_image((4, 3, 2), **place), "values", values, vtk_type)


def scalars(image):
    return arrays.to_numpy(image.GetPointData().GetScalars())


def assert_same_place(image, other, atol=0.0):
    np.testing.assert_allclose(
        ImageGeometry.of_image(image).grid.points(),
        ImageGeometry.of_image(other).grid.points(),
        atol=atol,
    )


def _structured_grid():
    grid = configured(vtkStructuredGrid(), Dimensions=(2, 2, 2))
    set_positions(grid, np.array([(n % 2, n // 2 % 2, n // 4) for n in range(8)]), VTK_FLOAT)
    return grid


MESHES = {
    ".vtu": lambda: output_of(vtkCellTypeSource()),
    ".vtk": lambda: output_of(vtkCellTypeSource()),
    ".vts": _structured_grid,
    **dict.fromkeys((".vtp", ".stl", ".ply"), lambda: output_of(vtkSphereSource())),
}


def matrix(image):
    """(3, 4) matrix from indices to the world of an image of ours."""
    grid = ImageGeometry.of_image(image).grid
    return np.column_stack([grid.index_to_world, grid.origin])


def in_lps(affine):
    return np.diag([-1, -1, 1]) @ affine[:3]


def itk_matrix(path):
    image = SimpleITK.ReadImage(str(path))
    direction = np.reshape(image.GetDirection(), (3, 3))
    return np.column_stack([direction * image.GetSpacing(), image.GetOrigin()])


def handles_on(grid):
    """p and q around the middle of a grid."""
    center = grid.corners().mean(axis=0)
    return [center + 1.6 * (places - (4, 4, 3)) for places in (REST, DEFORMED)]


def as_itk(direction, values=VALUES):
    image = SimpleITK.GetImageFromArray(values)
    image.SetOrigin(ORIGIN.tolist())
    image.SetSpacing(SPACING.tolist())
    image.SetDirection(direction.ravel().tolist())
    return image


def nrrd_bytes(space, direction, values=VALUES, more="", kind=""):
    """A NRRD file of the same image, in a space of eight, perhaps with an axis of components."""
    signs = frames.signs(space)
    steps = (direction * SPACING).T * signs
    vectors = [f"({','.join(map(repr, vector.tolist()))})" for vector in (*steps, ORIGIN * signs)]
    sizes = " ".join(map(str, [*values.shape[3:], 9, 8, 7]))
    directions, kinds = " ".join(vectors[:3]), "domain domain domain"
    if kind:
        directions, kinds = f"none {directions}", f"{kind} {kinds}"
    type_name = values.dtype.name.replace("float32", "float")
    header = (
        f"NRRD0005\ntype: {type_name}\ndimension: {values.ndim}\nspace: {space}\nsizes: {sizes}\n"
        f"space directions: {directions}\nkinds: {kinds}\n"
        f"endian: little\nencoding: gzip\nspace origin: {vectors[3]}\n{more}\n"
    )
    return header.encode() + gzip.compress(values.tobytes())


def as_nifti(direction, values=VALUES, kind=nibabel.Nifti1Image):
    affine = np.eye(4)
    affine[:3] = np.diag([-1, -1, 1]) @ np.column_stack([direction * SPACING, ORIGIN])
    return kind(values.T, affine)


def field_on(image, inverse=False):
    corners = ImageGeometry.of_image(image).grid.corners()
    moved = np.array(corners)
    moved[0] += 0.1 * (corners[-1] - corners[0])
    field = configured(MLSDisplacementField(), RestPoints=corners, DeformedPoints=moved)
    return update(configured(field, InputData=image, Inverse=inverse))


def nifti_header(size, **changes):
    header = nibabel.Nifti2Header()
    header.set_data_shape(size)
    header["vox_offset"], header["magic"] = 544, b"n+2\0\r\n\x1a\n"
    for name, value in changes.items():
        header[name] = value
    return header.binaryblock + bytes(4)


def limits(name):
    """A volume with the least and the greatest value of a type."""
    dtype = np.dtype(name)
    info = np.finfo(dtype) if dtype.kind == "f" else np.iinfo(dtype)
    values = VALUES.astype(dtype)
    values.flat[:2] = info.min, info.max
    return values


def assert_refused(path, content, sentence):
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(ValueError, match=sentence) as error:
        io.read_dataset(path)
    assert len(str(error.value)) < len(str(path)) + 240


def write_by_itk(path, values):
    SimpleITK.WriteImage(SimpleITK.GetImageFromArray(values), str(path))
    return path


def transform_by_itk(path):
    """The transform that SimpleITK reads from a file, or makes of an image of displacements."""
    path = str(path)
    if path.endswith(IMAGES):
        return SimpleITK.DisplacementFieldTransform(
            SimpleITK.ReadImage(path, SimpleITK.sitkVectorFloat64)
        )
    return SimpleITK.ReadTransform(path)
