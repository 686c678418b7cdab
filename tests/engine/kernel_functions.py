"""Calls single functions of the kernels for many arguments at once."""

from __future__ import annotations

import warnings

import numpy as np

from vtk_mls.engine.device import devices as device

_KERNEL = """
__kernel EXPLICIT_VECTORS void call(__global const float *table, const long count,
                                    __global const float *in, __global float *out) {{
  long first = (long)get_global_id(0) * LANES;
  real a[{inputs}], r[{outputs}];
  for (int i = 0; i < {inputs}; ++i) a[i] = LOAD(in + i * count + first);
  for (int i = 0; i < {outputs}; ++i) r[i] = 0;
  {body}
  for (int i = 0; i < {outputs}; ++i) STORE(r[i], out + i * count + first);
}}
"""


def call(key, lanes, files, body, arguments, outputs, table=(0.0,), **constants):
    """Results of OpenCL C that calls functions, for each row of arguments.

    Parameters
    ----------
    key : str
        Key of a device.
    lanes : int
        Rows per work item.
    files : sequence of str
        Files of opencl/ with the functions, in addition to types.cl.
    body : str
        Reads `real a[]`, a row of the arguments, and the floats `table`; writes `real r[]`.
    arguments : (n, inputs) array_like
        Converted to float32.
    outputs : int
        Numbers in `r`.

    Returns
    -------
    (n, outputs) float32
    """
    import pyopencl as cl

    chosen = next(found for found in device.list_devices() if found.key == key)
    rows = np.atleast_2d(np.asarray(arguments, np.float32))
    padded = np.resize(rows, (-(-len(rows) // 16) * 16, rows.shape[1]))
    text = _KERNEL.format(inputs=rows.shape[1], outputs=outputs, body=body)
    macros = tuple({"LANES": lanes, **constants}.items())
    text = "\n".join([device.source(name, macros) for name in ("types.cl", *files)] + [text])
    context, queue = device.context(chosen), device.queue(chosen)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # output of the compiler
        kernel = cl.Program(context, text).build(options=["-w"]).call
    copied = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
    tables, planes = (
        cl.Buffer(context, copied, hostbuf=np.ascontiguousarray(array, np.float32))
        for array in (table, padded.T)
    )
    result = np.empty((outputs, len(padded)), np.float32)
    out = cl.Buffer(context, cl.mem_flags.WRITE_ONLY, result.nbytes)
    kernel(queue, (len(padded) // lanes,), None, tables, np.int64(len(padded)), planes, out)
    cl.enqueue_copy(queue, result, out)
    return result.T[: len(rows)]
