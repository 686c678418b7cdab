"""An exception of a child process is raised in its parent."""

import json
import pickle

import pytest

from vtk_mls import DeviceError
from vtk_mls.base import child_process
from vtk_mls.base.errors import InputError

ERRORS = """
from vtk_mls import DeviceError
from vtk_mls.base.errors import InputError

class Odd(ValueError):
    pass

class OddOS(OSError):
    def __init__(self, path, code):
        super().__init__(f"{path} has {code}")

class Foreign(Exception):
    pass

def one(kind, *arguments):
    raise {**globals(), **__builtins__}[kind](*arguments)

def one_of_a_file():
    path = {"path": "{a}.csv", "name": "p of `{a}.csv`"}
    raise InputError("must be finite, got {}", argument="rest", **path)

def chained():
    try:
        {}["key"]
    except KeyError as error:
        raise DeviceError("no device") from error
"""


@pytest.fixture
def errors(tmp_path, monkeypatch):
    (tmp_path / "module_of_errors.py").write_text(ERRORS)
    monkeypatch.syspath_prepend(tmp_path)
    return "module_of_errors"


@pytest.mark.parametrize(
    ("kind", "arguments", "expected", "message"),
    [
        ("ValueError", ["one line"], ValueError, "one line"),
        (
            "ValueError",
            ["the header:\nline 3\n\nline 5"],
            ValueError,
            "the header:\nline 3\n\nline 5",
        ),
        ("ValueError", [], ValueError, ""),
        ("FileNotFoundError", [2, "No file", "a b"], FileNotFoundError, "[Errno 2] No file: 'a b'"),
        ("DeviceError", ["no memory: none"], DeviceError, "no memory: none"),
        ("MemoryError", [], MemoryError, ""),
        ("UnicodeDecodeError", ["ascii", [], 0, 1, ""], TypeError, None),
        ("Odd", ["one\ntwo"], ValueError, "Odd: one\ntwo"),
        ("OddOS", ["x", 3], OSError, "OddOS: x has 3"),
        ("Foreign", ["\ud800 \u00e4"], RuntimeError, "Foreign: \ud800 \u00e4"),
    ],
)
def test_the_class_and_the_message_are_kept(kind, arguments, expected, message, errors):
    with pytest.raises(Exception) as caught:  # noqa: PT011
        child_process.run(f"{errors}:one", kind, *arguments, timeout=120)
    assert type(caught.value) is expected
    assert message is None or str(caught.value) == message


def test_causes_are_kept(errors):
    with pytest.raises(DeviceError, match="no device") as caught:
        child_process.run(f"{errors}:chained", timeout=120)
    assert isinstance(caught.value.__cause__, KeyError)


def test_a_crash_is_no_exception():
    with pytest.raises(ChildProcessError, match="the process crashed"):
        child_process.run("os:abort", timeout=120)


def test_a_child_names_classes_of_exceptions_only(tmp_path):
    classes = [("builtins", "eval"), ("os", "system"), ("vtk_mls.io", "read_dataset")]
    record = {"classes": classes, "message": "1 / 0", "cause": None}
    (tmp_path / "error.json").write_text(json.dumps(record))
    found = child_process.error(tmp_path)
    assert (type(found), str(found)) == (RuntimeError, "eval: 1 / 0")


def test_an_error_keeps_its_argument_and_its_file(errors):
    with pytest.raises(InputError) as caught:
        child_process.run(f"{errors}:one_of_a_file", timeout=120)
    found = caught.value
    assert str(found) == "p of `{a}.csv` must be finite, got {}"
    assert (found.argument, found.path) == ("rest", "{a}.csv")
    assert str(found.renamed({"rest": "`b`"})) == "`b` must be finite, got {}"
    assert str(pickle.loads(pickle.dumps(found)).renamed({})) == str(found)
