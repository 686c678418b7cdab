"""Engines have the same interface."""

import inspect

import pytest

from vtk_mls.engine import opencl_engine as engine
from vtk_mls.engine import protocol
from vtk_mls.reference import reference_engine as reference


def questions(answers):
    """The names and kinds of the parameters of each public function of an engine, but self."""
    module = answers.__name__ if inspect.ismodule(answers) else answers.__module__
    functions = {
        name: inspect.signature(value).parameters.values()
        for name, value in vars(answers).items()
        if inspect.isfunction(value) and value.__module__ == module and name[0] != "_"
    }
    return {
        name: [(p.name, p.kind) for p in parameters if p.name != "self"]
        for name, parameters in functions.items()
    }


@pytest.mark.parametrize("answers", [reference, engine.Engine], ids=["reference", "OpenCL"])
def test_engines_keep_to_the_protocol(answers):
    assert len(questions(protocol.Engine)) > 10
    assert questions(answers) == questions(protocol.Engine)
