"""Facts about a dataset's file, as field data (vtkStringArray).

Field data pass through filters, so that a writer finds what its format needs.
"""

from vtk_mls.vtk import arrays

SPACE = "Space"  # frame of control points
FILE_SPACE = "FileSpace"  # frame of the file; the dataset itself is in LPS
FILE_GRID = "FileGrid"  # of an image whose header is kept: dimensions, origin and steps
LABEL_ARRAYS = "LabelArrays"  # names of point and cell arrays whose values must not be mixed
LENGTH_UNIT = "LengthUnit"  # of coordinates, if the file says one that is not converted
TIME_UNIT = "TimeUnit"  # of the time steps, as in `volumes.Volume`
NRRD_HEADER = "NrrdHeader"  # lines of the header, such as the names and colors of segments
NIFTI_HEADER = "NiftiHeader"  # lines `field: value`
METAIMAGE_HEADER = "MetaImageHeader"  # lines `key = value`
FORWARD_DISPLACEMENT = "ForwardDisplacement"  # name of the array of a field that moves points


def store(dataset, name, texts):
    """Replace the texts of a name; without texts the name is removed."""
    dataset.GetFieldData().RemoveArray(name)
    if texts:
        arrays.add_texts(dataset.GetFieldData(), name, texts)


def load(dataset, name):
    """The texts of a name, () without."""
    return tuple(arrays.texts(dataset.GetFieldData(), name))
