"""Structs and constants that host and kernels share."""

import re
import warnings

import numpy as np
import pytest
from control_point_sets import DEVICES, OTHER_DEVICES

pytest.importorskip("pyopencl", reason="there is no OpenCL without pyopencl")

from vtk_mls.engine.device import devices as device
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, STRUCTS
from vtk_mls.queries import void_cells


@pytest.mark.parametrize("key", [*DEVICES, *OTHER_DEVICES])
def test_structs_are_laid_out_alike_on_host_and_device(key):
    import pyopencl as cl

    expected, lines = [], []
    for name, dtype in STRUCTS.items():
        lines.append(f"{name} {name}_it; out[{len(expected)}] = (int)sizeof({name}_it);")
        expected.append(dtype.itemsize)
        for member in dtype.names:
            offset = f"(char *)&{name}_it.{member} - (char *)&{name}_it"
            lines.append(f"out[{len(expected)}] = (int)({offset});")
            expected.append(dtype.fields[member][1])
    body = "\n".join(lines)
    text = f"{device.source('structs.h')}\n__kernel void layout(__global int *out) {{ {body} }}"
    chosen = next(found for found in device.list_devices() if found.key == key)
    context, queue = device.context(chosen), device.queue(chosen)
    layout = np.zeros(len(expected), np.int32)
    out = cl.Buffer(context, cl.mem_flags.WRITE_ONLY, layout.nbytes)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        kernel = cl.Program(context, text).build(options=["-w"]).layout
    kernel(queue, (1,), (1,), out)
    cl.enqueue_copy(queue, layout, out)
    np.testing.assert_array_equal(layout, expected)


@pytest.mark.parametrize("dtype", STRUCTS.values(), ids=STRUCTS)
def test_structs_end_with_a_member(dtype):
    """rusticl 22.3 does not count padding at the end."""
    last = dtype.names[-1]
    assert dtype.fields[last][1] + dtype[last].itemsize == dtype.itemsize


@pytest.mark.parametrize("name", ["VOID", "TOUCHED", "UNKNOWN"])
def test_flags_of_void_cells_are_those_of_the_host(name):
    assert CONSTANTS[name] == getattr(void_cells, name)


@pytest.mark.parametrize(("name", "order"), [("tap_weight", 0), ("tap_slope", 1)])
def test_weights_between_nodes_are_those_of_lagrange_polynomials(name, order):
    text = re.search(rf"{name}\[.*?= \{{(.*?)\}};", device.source("coarse_map.cl"), re.DOTALL)[1]
    weights = [float(weight) for weight in re.findall(r"(-?[\d.]+)f", text)]
    nodes, step = np.arange(-2, 4), CONSTANTS["COARSE_STEP"]
    polynomials = [
        np.poly1d(np.delete(nodes, i), r=True) / np.prod(nodes[i] - np.delete(nodes, i))
        for i in range(len(nodes))
    ]
    expected = [
        polynomial.deriv(order)(k / step) / step**order
        for k in range(step)
        for polynomial in polynomials
    ]
    np.testing.assert_allclose(weights, expected, rtol=6e-8, atol=1e-18)
