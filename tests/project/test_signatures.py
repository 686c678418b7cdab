"""Engines have the same interface."""

import inspect

import pytest

from vtk_mls.engine import opencl_engine as engine
from vtk_mls.engine import protocol
from vtk_mls.reference import reference_engine as reference

QUESTIONS = (
    *("backward", "void_distance", "forward", "jacobian", "least_determinant"),
    *("displacement_field", "jacobian_field"),
    *("resample", "gradient", "source_index", "origins_from", "sample"),
    *("void_by_corners", "void_distance_listed", "doubtful_voxels"),
)


def parameters(function):
    """Names and kinds of the parameters of a question but self."""
    found = inspect.signature(function).parameters.values()
    return [(parameter.name, parameter.kind) for parameter in found if parameter.name != "self"]


def test_the_protocol_has_the_questions():
    public = {name for name, value in vars(protocol.Engine).items() if inspect.isfunction(value)}
    assert {name for name in public if not name.startswith("_")} == {*QUESTIONS}
    for name in QUESTIONS:
        assert getattr(protocol.Engine, name).__doc__
    assert protocol.Engine.__annotations__.keys() == {"NAME"}


@pytest.mark.parametrize("answers", [reference, engine.Engine], ids=["reference", "OpenCL"])
def test_engines_keep_to_the_protocol(answers):
    for name in QUESTIONS:
        assert parameters(getattr(answers, name)) == parameters(getattr(protocol.Engine, name)), (
            name
        )
    public = {name for name, value in vars(answers).items() if inspect.isfunction(value)}
    module = answers.__name__ if inspect.ismodule(answers) else answers.__module__
    own = {name for name in public if getattr(answers, name).__module__ == module}
    assert {name for name in own if not name.startswith("_")} == {*QUESTIONS}
