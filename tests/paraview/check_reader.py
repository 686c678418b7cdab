"""MLS Image Reader opens medical images, and converts them to LPS."""

import os
import tempfile

import numpy as np
from paraview import servermanager, simple
from paraview.modules.vtkRemotingServerManager import vtkSMProxyManager
from scene import array, data, output_messages

from vtk_mls import io
from vtk_mls.vtk.arrays import ImageGeometry

factory = vtkSMProxyManager.GetProxyManager().GetReaderFactory()
session = servermanager.ActiveConnection.Session
VALUES = np.arange(4 * 5 * 6, dtype="<i2").reshape(4, 5, 6)
ORIGIN = np.array([10.0, 20.0, 30.0])
STEPS = np.array([[0.8, -1.2, 0], [0.6, 1.6, 0], [0, 0, 3]])  # columns are steps between voxels

IN_LPS = np.indices(VALUES.shape)[::-1].reshape(3, -1).T @ STEPS.T + ORIGIN


def write_files(folder):
    """The names of files with `VALUES` in every format."""
    columns = [f"({','.join(map(str, column))})" for column in STEPS.T]
    nrrd = {
        "type": "short",
        "dimension": "3",
        "space": "left-posterior-superior",
        "sizes": "6 5 4",
        "space directions": " ".join(columns),
        "endian": "little",
        "encoding": "raw",
        "space origin": "(" + ",".join(map(str, ORIGIN)) + ")",
    }
    frames = {"lps": "left-posterior-superior", "ras": "right-anterior-superior"}
    for name, frame in {**frames, "labels.seg": frames["lps"]}.items():
        header = "".join(f"{key}: {value}\n" for key, value in {**nrrd, "space": frame}.items())
        with open(os.path.join(folder, f"{name}.nrrd"), "wb") as file:
            file.write(f"NRRD0004\n{header}\n".encode() + VALUES.tobytes())
    image = io.read_dataset(os.path.join(folder, "lps.nrrd"))
    for name in ("plain.nii", "packed.nii.gz", "local.mha", "detached.mhd"):
        io.write_dataset(image, os.path.join(folder, name))
    with open(os.path.join(folder, "detached.nhdr"), "w") as file:
        header = "".join(f"{key}: {value}\n" for key, value in nrrd.items())
        file.write(f"NRRD0004\n{header}data file: detached.raw\n")
    return [name for name in os.listdir(folder) if not name.endswith(".raw")]


def readers(file):
    """The names of the readers that ParaView's file dialog would offer."""
    found = factory.GetReaders(file, session)
    return [found.GetString(i) for i in range(1, found.GetLength(), 3)]


def by_value(image):
    """The values of an image, which are all different, in their order, with their places."""
    values = array(image, image.GetPointData().GetScalars().GetName()).ravel()
    places = np.array([image.GetPoint(i) for i in range(image.GetNumberOfPoints())])
    return np.sort(values), places[np.argsort(values)]


types = factory.GetSupportedFileTypes(session).split(";;")
(offered,) = (name for name in types if "MLS" in name)
for suffix in ("nii", "nii.gz", "nrrd", "nhdr", "mha", "mhd"):
    assert f"*.{suffix} " in offered.replace(")", " "), offered

with tempfile.TemporaryDirectory() as folder:
    files = write_files(folder)
    assert len(files) == 8
    for name in files:
        file = os.path.join(folder, name)
        assert "MLSImageReader" in readers(file)
        reader = simple.OpenDataFile(file)
        assert reader.SMProxy.GetXMLName() == "MLSImageReader"
        image = data(reader)
        values, places = by_value(image)
        np.testing.assert_array_equal(values, VALUES.ravel())
        np.testing.assert_allclose(
            places, IN_LPS * ([-1, -1, 1] if name == "ras.nrrd" else 1), atol=1e-5
        )
        assert (np.diagonal(ImageGeometry.of_image(image).grid.direction) > 0.5).all()
        reader.UpdatePipeline(time=3.0)
        simple.MLSDeform(Input=reader).UpdatePipeline()
        simple.Delete(reader)

    # Reload reads it again; a broken and a missing file give one error with the name.
    file = os.path.join(folder, "local.mha")
    reader = simple.OpenDataFile(file)
    assert array(data(reader), "MetaImage").max() == VALUES.max()
    with open(file, "r+b") as local:
        content = local.read()
        local.seek(len(content) - VALUES.nbytes)
        local.write((VALUES + 1).tobytes())
    simple.ReloadFiles(reader)
    assert array(data(reader), "MetaImage").max() == VALUES.max() + 1
    broken = os.path.join(folder, "broken.nrrd")
    with open(broken, "w") as local:
        local.write("NRRD0004\ntype: short\n\n")
    for bad in (broken, os.path.join(folder, "missing.nii")):
        with output_messages() as text:
            reader.FileName = bad
            reader.UpdatePipeline()
        assert bad in text[0], text[0]
        assert "Traceback" not in text[0], text[0]
        assert text[0].count("MLSImageReader: ") == 1, text[0]
        assert reader.GetClientSideObject().GetOutputDataObject(0).GetNumberOfPoints() == 0
    reader.FileName = file
    assert array(data(reader), "MetaImage").max() == VALUES.max() + 1
