"""Short parameter lists, and engines with the same interface."""

import ast
import inspect
from pathlib import Path

import pytest

from vtk_mls.engine import engine, protocol
from vtk_mls.model.options import DEFORMATION_OPTIONS
from vtk_mls.reference import engine as reference

PACKAGE = Path(__file__).parents[2] / "vtk_mls"
MAX_PARAMETERS = 8
QUESTIONS = (
    *("backward", "void_distance", "forward", "jacobian", "least_determinant"),
    *("displacement_field", "jacobian_field"),
    *("resample", "gradient", "source_bounds", "source_index", "origins_from", "sample"),
    *("void_by_corners", "void_distance_listed"),
)


def functions():
    """Name of every function and method of the package, and its parameters except self and cls."""
    for path in sorted(PACKAGE.rglob("*.py")):
        module = path.relative_to(PACKAGE).with_suffix("").as_posix().replace("/", ".")
        yield from within(module, ast.parse(path.read_text()))


def within(name, tree):
    """The same for a syntax tree."""
    for node in ast.iter_child_nodes(tree):
        inner = f"{name}.{node.name}" if hasattr(node, "name") else name
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            args = node.args
            args = [*args.posonlyargs, *args.args, args.vararg, *args.kwonlyargs, args.kwarg]
            names = [arg.arg for arg in args if arg is not None]
            is_method = isinstance(tree, ast.ClassDef) and names[:1] in (["self"], ["cls"])
            yield inner, names[1:] if is_method else names
        yield from within(inner, node)


def test_no_list_of_parameters_is_long():
    options = {option.name for option in DEFORMATION_OPTIONS}
    found = {name: {*names} - options for name, names in functions()}
    assert not {name: names for name, names in found.items() if len(names) > MAX_PARAMETERS}


def test_the_test_counts_all_parameters():
    text = "class A:\n def f(self, a, b, /, c, *d, e=1, **g):\n  def h(self): ..."
    found = {name: "".join(names) for name, names in within("m", ast.parse(text))}
    assert found == {"m.A.f": "abcdeg", "m.A.f.h": "self"}


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
