"""Deformations in steps by the command."""

import pytest
from vtk_fixtures import FAST
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtk_mls import io
from vtk_mls.commands.cli import main

HANDLES = """px,py,pz,qx,qy,qz
0,0,0,0,0,0
4,4,4,7,4,4
6,4,4,3,4.5,4
8,8,8,8,8,8
"""


@pytest.mark.parametrize("steps", ["auto", "8", "1"])
def test_steps(files, steps):
    (files / "crossed.csv").write_text(HANDLES)
    command = ["field", "in.vti", "crossed.csv", "out.vti", "--device", FAST]
    assert main([*command, "--steps", steps]) == 0
    data = io.read_dataset("out.vti").GetFieldData()
    assert data.HasArray("StepsUsed") == (steps == "auto")
    if steps == "auto":
        assert vtk_to_numpy(data.GetArray("SmallestDeterminant"))[0] > 0.1


@pytest.mark.parametrize("steps", ["many", "1.5"])
def test_bad_steps(files, steps, capsys):
    with pytest.raises(SystemExit):
        main(["field", "in.vti", "handles.csv", "out.vti", "--steps", steps])
    assert "--steps" in capsys.readouterr().err
