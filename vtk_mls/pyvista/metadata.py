"""PyVista's metadata of datasets: bool, complex and active arrays.

VTK holds bool and complex arrays as uint8 and pairs of floats. PyVista's own filters copy the
metadata by `copy_meta_from`.
"""

import pyvista

# PyVista's names of the attributes, and how to get them.
_ATTRIBUTES = {"POINT": "GetPointData", "CELL": "GetCellData", "NONE": "GetFieldData"}
_BOOL, _COMPLEX = "_association_bitarray_names", "_association_complex_names"


def flags(data):
    """`__this__` of the arrays of bool of a DataSet or MultiBlock: a set."""
    return {
        array.__this__
        for dataset, _ in _pairs(data, data)
        for key in _ATTRIBUTES
        for name in getattr(dataset, _BOOL).get(key, ())
        if (array := _array(dataset, key, name)) is not None
    }


def copy(data, result):
    """Copy active arrays and types of arrays of a DataSet or MultiBlock to a result."""
    for dataset, output in _pairs(data, result):
        output.copy_meta_from(dataset, deep=True)
    copy_types(data, result)


def copy_types(data, result):
    """Make arrays bool or complex if they are in `data` and have the same VTK type."""
    for dataset, output in _pairs(data, result):
        for kind in (_BOOL, _COMPLEX):
            for key, names in getattr(dataset, kind).items():
                same = {name for name in names if _has_same_type(dataset, output, key, name)}
                getattr(output, kind)[key] = same


def _pairs(data, result):
    """The datasets of `data`, each with the dataset at the same place of `result`."""
    if isinstance(data, pyvista.MultiBlock):
        for pair in zip(data, result):
            yield from _pairs(*pair)
    elif isinstance(data, pyvista.DataSet) and isinstance(result, pyvista.DataSet):
        yield data, result


def _has_same_type(dataset, output, key, name):
    """Whether both datasets have an array of one type."""
    old, new = _array(dataset, key, name), _array(output, key, name)
    return (
        old is not None
        and new is not None
        and old.GetDataType() == new.GetDataType()
        and old.GetNumberOfComponents() == new.GetNumberOfComponents()
    )


def _array(dataset, key, name):
    return getattr(dataset, _ATTRIBUTES[key])().GetArray(name)
