"""`vtk-mls demo`: cuts a real brain open, and leaves files to look at."""

import importlib.util
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth
from vtkmodules.vtkIOImage import vtkNIFTIImageReader

from vtk_mls import HalfPlane, io
from vtk_mls.files.paths import check_folder
from vtk_mls.files.vtk_io import write_png
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk.objects import configured, output_of, shallow_copy

# Positions in millimeters: x to the right, y to the front, z up. The edge of the cut runs along x.
EDGE = (98.0, 118.0, 58.0)
FRONT = ((157, 125, 115), (112, 125, 149), (159, 146, 102), (150, 175, 88), (125, 177, 117))
BACK = ((157, 111, 116), (117, 111, 150), (165, 88, 103), (152, 59, 88), (127, 54, 120))
BELOW = ((157, 142, 53), (163, 86, 51), (113, 114, 36), (135, 52, 25), (127, 171, 51))
DEGREES = 35  # by which each half is rotated about the edge


def add(parser):
    parser.description = (
        "Cut a real brain open; leave the image, its handles, the deformed image and a "
        "picture of both. `make demo` in a checkout draws more."
    )
    parser.add_argument("directory", nargs="?", default="vtk-mls-demo", help="default: %(default)s")


def run(options):
    check_folder(options.directory)
    directory = Path(options.directory)
    image = brain()
    directory.mkdir(parents=True, exist_ok=True)
    rest, deformed = control_points()
    deform = configured(MLSDeform(), InputData=image, RestPoints=rest, DeformedPoints=deformed)
    deform.AddCut(HalfPlane(EDGE, normal=(0, 1, 0), inward=(0, 0, 1)))
    deform.SetOutputGrid("fitted")
    deform.Update()
    io.write_dataset(image, directory / "brain.vti")
    io.write_handles(directory / "handles.vtp", rest, deformed)
    io.write_dataset(deform.GetOutput(), directory / "cut.vti")
    _write_slices((image, deform.GetOutput()), directory / "cut.png")
    print(
        f"A brain of {' x '.join(map(str, image.GetDimensions()))} voxels, cut from above and "
        f"pulled open by {len(rest)} handles: brain.vti, handles.vtp, cut.vti and a slice of both, "
        f"cut.png, in {directory}\nDrag the handles yourself: vtk-mls view "
        f"{directory / 'brain.vti'} {directory / 'handles.vtp'}"
    )
    return 0


def brain():
    """T1-weighted image of the MNI152 brain, smoothed a little."""
    reader = configured(vtkNIFTIImageReader(), FileName=str(brain_file()))
    smooth = configured(vtkImageGaussianSmooth(), StandardDeviation=0.8)
    image = shallow_copy(output_of(smooth, InputConnection=reader.GetOutputPort()))
    image.GetPointData().GetScalars().SetName("T1")
    return image


def control_points(degrees=DEGREES):
    """Rest and deformed positions (n, 3): both halves rotate outward, the points below stay."""
    groups = np.array((FRONT, BACK, BELOW), float)
    mirrored = groups * (-1, 1, 1) + (2 * EDGE[0], 0, 0)
    front, back, below = np.concatenate([groups, mirrored], axis=1)  # on both sides
    angle = np.radians(degrees)
    deformed = np.vstack([_rotated(front, -angle), _rotated(back, angle), below])
    return np.vstack([front, back, below]), deformed


def brain_file():
    """The T1-weighted MNI152 brain (.nii.gz, without skull) in the package nilearn.

    FileNotFoundError if it is not installed.
    """
    name = "datasets/data/mni_icbm152_t1_tal_nlin_sym_09a_converted.nii.gz"
    return file_of("nilearn", name, "0.8.1")


def file_of(package, name, version):
    """A file of a package, without an import of the package; `version` is the first that has it."""
    spec = importlib.util.find_spec(package)
    for folder in spec.submodule_search_locations if spec else []:
        file = Path(folder) / name
        if file.is_file():
            return file
    raise FileNotFoundError(
        f"the demo's volume comes with the package {package}, {version} or later: "
        f"pip install {package}"
    )


def _rotated(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return EDGE + (points - EDGE) @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


def _write_slices(images, file):
    """Write a picture of the slice at the middle of the first image, through each of them."""
    x, slices = images[0].GetCenter()[0] + 30, []
    for image in images:
        values = vtk_to_numpy(image.GetPointData().GetArray("T1"))
        i = int(np.rint((x - image.GetOrigin()[0]) / image.GetSpacing()[0]))
        slices.append(values.reshape(image.GetDimensions()[::-1])[:, :, i])
    height = max(len(rows) for rows in slices)
    padded = [np.pad(rows, ((0, height - len(rows)), (4, 4))) for rows in slices]
    pixels = np.hstack(padded).clip(0, 255).astype(np.uint8)
    picture = configured(vtkImageData(), Dimensions=(*pixels.shape[::-1], 1))
    picture.GetPointData().SetScalars(numpy_to_vtk(pixels.ravel(), deep=True))
    write_png(picture, file)
