"""Structs that the host fills and kernels take."""

import numpy as np
import pytest

pytest.importorskip("pyopencl", reason="there is no OpenCL without pyopencl")

from vtk_mls.engine import kernel_arguments


def structs():
    found = vars(kernel_arguments).items()
    return {name: each for name, each in found if isinstance(each, np.dtype)}


@pytest.mark.parametrize("name", structs())
def test_structs_are_laid_out_as_in_c_and_end_with_a_member(name):
    struct = structs()[name]
    members = [(each, struct[each]) for each in struct.names]
    assert np.dtype(members, align=True).itemsize == struct.itemsize
    last = struct.names[-1]
    assert struct.fields[last][1] + struct[last].itemsize == struct.itemsize


def test_records_of_kinds_and_cuts_too():
    record = kernel_arguments.record({"far": np.int64(3), "near": np.int32(1)})
    assert record.dtype.itemsize == 16
    assert kernel_arguments.members(record.dtype) == "long far; int near; int padding[1];"
