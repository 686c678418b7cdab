"""An image of ParaView's own reader and handles of a file: a warning where they are not in one
world, and nothing is said where they are or where nobody knows.
"""

import os
import tempfile

import numpy as np
from paraview import simple
from scene import output_messages

from vtk_mls.files import control_point_files

HANDLES = np.array([(0.0, 0, 0), (5, 0, 0), (0, 5, 0), (0, 0, 5)])
NRRD = """NRRD0004
type: uchar
dimension: 3
space: RAS
sizes: 4 4 4
space directions: (1,0,0) (0,1,0) (0,0,1)
encoding: raw
space origin: (3,4,5)

"""
META = """ObjectType = Image
NDims = 3
DimSize = 4 4 4
ElementSpacing = 1 1 1
Offset = 3 4 5
TransformMatrix = {matrix}
ElementType = MET_UCHAR
ElementDataFile = LOCAL
"""


def warning(image, handles):
    """What the filters say."""
    filters = [each(Input=image, ControlPoints=handles) for each in FILTERS]
    with output_messages() as text:
        for each in filters:
            each.UpdatePipeline()
            assert each.GetClientSideObject().GetOutputDataObject(0).GetNumberOfPoints() > 0
    return text[0]


FILTERS = simple.MLSDeform, simple.MLSDisplacementField
MetaImageReader = getattr(simple, "MetaImageReader", None) or simple.MetaFileSeriesReader
with tempfile.TemporaryDirectory() as folder:
    markups, identity = os.path.join(folder, "handles.mrk.json"), "1 0 0 0 1 0 0 0 1"
    control_point_files.write(markups, HANDLES, HANDLES)
    filed = simple.MLSControlPoints(Mode="file", FileName=markups)
    listed = simple.MLSControlPoints(
        RestPoints=list(HANDLES.ravel()), DeformedPoints=list(HANDLES.ravel())
    )
    for name, header, is_elsewhere in (
        ("ras.nrrd", NRRD, True),
        ("plain.mha", META.format(matrix=identity), False),
        ("turned.mha", META.format(matrix="0 1 0 -1 0 0 0 0 1"), True),
    ):
        file = os.path.join(folder, name)
        with open(file, "wb") as written:
            written.write(header.encode() + bytes(64))
        if name.endswith("nrrd"):
            theirs = simple.NrrdReader(FileName=file)
        else:
            theirs = MetaImageReader(FileNames=[file])
        found = warning(theirs, filed)
        expected = f"does not place {file} in LPS, where `ControlPoints` are"
        assert found.count(expected) == 2 if is_elsewhere else found == "", found
        assert warning(simple.MLSImageReader(FileName=file), filed) == ""
        assert warning(theirs, listed) == ""
        between = simple.Calculator(Input=theirs, Function="1")  # might have mended it
        assert warning(between, filed) == ""
