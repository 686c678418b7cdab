"""A warning if an image of ParaView's own reader and handles of a file are in different frames."""

import os
import tempfile

import numpy as np
from paraview import simple
from scene import control_points, output_messages

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
    filters = [kind(Input=image, ControlPoints=handles) for kind in FILTERS]
    with output_messages() as text:
        for proxy in filters:
            proxy.UpdatePipeline()
            assert proxy.GetClientSideObject().GetOutputDataObject(0).GetNumberOfPoints() > 0
    return text[0]


FILTERS = simple.MLSDeform, simple.MLSDisplacementField
MetaImageReader = getattr(simple, "MetaImageReader", None) or simple.MetaFileSeriesReader
with tempfile.TemporaryDirectory() as folder:
    markups, identity = os.path.join(folder, "handles.mrk.json"), "1 0 0 0 1 0 0 0 1"
    control_point_files.write(markups, HANDLES, HANDLES)
    from_file = simple.MLSControlPoints(Mode="file", FileName=markups)
    from_list = control_points(HANDLES, HANDLES)
    for name, header, is_misplaced in (
        ("ras.nrrd", NRRD, True),
        ("plain.mha", META.format(matrix=identity), False),
        ("turned.mha", META.format(matrix="0 1 0 -1 0 0 0 0 1"), True),
    ):
        file = os.path.join(folder, name)
        with open(file, "wb") as stream:
            stream.write(header.encode() + bytes(64))
        if name.endswith("nrrd"):
            reader = simple.NrrdReader(FileName=file)
        else:
            reader = MetaImageReader(FileNames=[file])
        found = warning(reader, from_file)
        expected = f"does not place {file} in LPS, where `ControlPoints` are"
        assert found.count(expected) == 2 if is_misplaced else found == "", found
        assert warning(simple.MLSImageReader(FileName=file), from_file) == ""
        assert warning(reader, from_list) == ""
        between = simple.Calculator(Input=reader, Function="1")  # might convert
        assert warning(between, from_file) == ""
