"""What a dataset keeps of the file that it came from, as field data.

Field data pass through filters, so that a writer still finds what its format needs. Each is a
vtkStringArray.
"""

from __future__ import annotations

from vtkmodules.vtkCommonCore import vtkStringArray

FILE_SPACE = "FileSpace"  # name of the file's own frame; the dataset itself is in LPS
LABEL_ARRAYS = "LabelArrays"  # names of point and cell arrays whose values must not be mixed
NRRD_HEADER = "NrrdHeader"  # lines of the header, such as the names and colours of segments
NIFTI_HEADER = "NiftiHeader"  # lines `field: value`


def keep(dataset, name, texts):
    """Give a dataset the texts, or none."""
    dataset.GetFieldData().RemoveArray(name)
    if texts:
        array = vtkStringArray()
        array.SetName(name)
        for text in texts:
            array.InsertNextValue(text)
        dataset.GetFieldData().AddArray(array)


def kept(dataset, name):
    """The texts of a dataset, () if there are none."""
    array = dataset.GetFieldData().GetAbstractArray(name)
    if not isinstance(array, vtkStringArray):
        return ()
    texts = (array.GetValue(i) for i in range(array.GetNumberOfValues()))
    # bytes are what VTK gives of texts that are not UTF-8
    return tuple(text if isinstance(text, str) else text.decode("latin-1") for text in texts)
