"""The check of a device launches kernels of every sort."""

from vtk_mls.commands import kernel_checks
from vtk_mls.engine import dispatch
from vtk_mls.engine.opencl_engine import Engine

REQUIRED = {
    *("point_displacement", "point_jacobian", "point_inverse", "grid_displacement"),
    *("point_forward", "lattice_cells", "local_points", "node_origin", "node_cell"),
    *("grid_source_index", "resample", "gradient", "void_by_corners"),
    *("node_displacement", "coarse_check", "coarse_displacement", "coarse_source_index"),
}


def test_kernels_of_every_sort_are_launched(key, launched):
    engine = Engine(dispatch.choose(key))
    for checks in kernel_checks.checks(engine).values():
        for _, results, bound in checks:
            assert kernel_checks.error(engine, results) <= bound
    assert dict(launched).keys() >= REQUIRED
