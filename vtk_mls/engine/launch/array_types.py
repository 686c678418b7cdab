"""Element types of arrays, and the build constants of kernels that read them."""

from __future__ import annotations

_C_TYPES = {
    **{"int8": "char", "uint8": "uchar", "int16": "short", "uint16": "ushort"},
    **{"int32": "int", "uint32": "uint", "int64": "long", "uint64": "ulong"},
    **{"float32": "float", "float64": "double"},
}
# float32 is exact enough for values of these types and their sums
_SUMMED_IN_FLOAT = ("int8", "uint8", "int16", "uint16", "float32")


def is_for_device(array, device):
    """Whether kernels of a device can read an array."""
    name = array.dtype.name
    sums = name in _SUMMED_IN_FLOAT or device.has_float64
    return name in _C_TYPES and sums


def c_type(array):
    """The type of its elements in OpenCL C."""
    return _C_TYPES[array.dtype.name]


def constants(array, launcher):
    """Build constants of kernels that read an array."""
    return (
        *launcher.sums(double=array.dtype.name not in _SUMMED_IN_FLOAT),
        ("VALUE", c_type(array)),
        offset(array),
    )


def offset(array):
    """The build constant for offsets in an array."""
    return "OFFSET", "int" if array.size < 2**31 else "long"
