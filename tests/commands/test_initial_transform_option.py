"""`--initial-transform`: a warp of another program is corrected by hand."""

import numpy as np
import pytest
from vtk_fixtures import DEFORMED, REST

from vtk_mls import Chain, Deformation, Field, Grid, io
from vtk_mls.commands.cli import main
from vtk_mls.files import control_point_files
from vtk_mls.files.landmarks import Landmarks
from vtk_mls.vtk import arrays

PLACES = np.random.default_rng(13).uniform(2, 6, (5, 3))


@pytest.fixture
def initial(files):
    """A field, in the file warp.nrrd."""
    grid = Grid((5, 5, 5), (-1, -1, -1), (2.5, 2.5, 2.5))
    value = Field(np.random.default_rng(3).normal(0, 0.3, (*grid.shape, 3)), grid)
    io.write_transform(value, "warp.nrrd")
    return value


def chained(initial):
    return Chain([initial, Deformation(REST, DEFORMED, device="reference")])


def command(name, *arguments):
    return main([name, *arguments, "--initial-transform", "warp.nrrd"])


def test_handles_at_rest_leave_the_initial_transform(initial, capsys):
    """They would be an error without it: nothing would move."""
    np.savetxt(
        "rest.csv", np.hstack([REST, REST]), delimiter=",", header="px,py,pz,qx,qy,qz", comments=""
    )
    assert command("deform", "in.vti", "rest.csv", "out.vti") == 0
    assert "nothing moves" not in capsys.readouterr().out
    image, output = (io.read_dataset(name) for name in ("in.vti", "out.vti"))
    values = [arrays.to_numpy(data.GetPointData().GetScalars()) for data in (image, output)]
    assert (values[0] != values[1]).any()


@pytest.mark.parametrize("inverse", [False, True])
def test_points(initial, inverse):
    control_point_files.write_landmarks("in.csv", Landmarks("", PLACES, "LPS", list("abcde")))
    option = ["--inverse"] * inverse
    assert command("points", "in.csv", "handles.csv", "out.csv", *option) == 0
    chain = chained(initial)
    expected = (chain.backward if inverse else chain.forward)(PLACES)
    got = control_point_files.read_landmarks("out.csv").positions
    np.testing.assert_allclose(got, expected, rtol=1e-9)
    assert np.abs(got - chain.transforms[1].forward(PLACES)).max() > 0.05


def test_a_missing_file_is_named(initial, refused):
    arguments = "deform", "in.vti", "handles.csv", "out.vti", "--initial-transform", "no.h5"
    assert refused(*arguments) == "there is no file `no.h5`"
