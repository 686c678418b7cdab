"""Files of control points as PyVista's points, in LPS."""

import pyvista

from vtk_mls import io

# Registered with `pyvista.read`, which sees only the last ending: other files can be .csv or .json.
ENDINGS = (".fcsv",)


def read(path, deformed=None, space="LPS"):
    """Read control points of any format that `vtk-mls deform` reads, such as .csv and .mrk.json.

    `pyvista.read` does so with .fcsv.

    Parameters
    ----------
    path : path
        Pairs, or positions p.
    deformed : path, optional
        Positions q to which those of `path` were moved.
    space : "LPS" or "RAS"
        Frame of files that do not say theirs.

    Returns
    -------
    pyvista.PolyData
        Points p with the vectors "Displacement", q - p, and if the file has them "Weight" and
        "Label": what `mesh.mls.deform` takes.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    return pyvista.wrap(io.read_control_points(path, deformed, space))


for ending in ENDINGS:
    pyvista.register_reader(ending, read)
