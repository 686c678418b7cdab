"""What a dataset keeps of the file that it came from, as field data.

Field data pass through filters, so that a writer still finds what its format needs. Each is a
vtkStringArray.
"""

from __future__ import annotations

from vtk_mls.vtk import arrays

SPACE = "Space"  # name of the frame of control points
FILE_SPACE = "FileSpace"  # name of the file's own frame; the dataset itself is in LPS
LABEL_ARRAYS = "LabelArrays"  # names of point and cell arrays whose values must not be mixed
NRRD_HEADER = "NrrdHeader"  # lines of the header, such as the names and colours of segments
NIFTI_HEADER = "NiftiHeader"  # lines `field: value`
METAIMAGE_HEADER = "MetaImageHeader"  # lines `key = value`
FORWARD_DISPLACEMENT = "ForwardDisplacement"  # name of the array of a field that moves points


def keep(dataset, name, texts):
    """Give a dataset the texts, or none."""
    dataset.GetFieldData().RemoveArray(name)
    if texts:
        arrays.add_texts(dataset.GetFieldData(), name, texts)


def kept(dataset, name):
    """The texts of a dataset, () if there are none."""
    return tuple(arrays.texts(dataset.GetFieldData(), name))
