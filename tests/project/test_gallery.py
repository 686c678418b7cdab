"""Each example says what one sees, is short, and ends with a check of a number."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.py"))
LINES = 60  # that are not empty and no comments


def is_check(statement):
    """Whether it ends in an assertion that compares something with a number."""
    while isinstance(statement, (ast.For, ast.With, ast.If)):
        statement = statement.body[-1]
    return isinstance(statement, ast.Assert)


def compares(tree):
    """Whether an assertion of a program compares with a number."""
    tests = [node.test for node in ast.walk(tree) if isinstance(node, ast.Assert)]
    pairs = [test for test in tests if isinstance(test, ast.Compare)]
    return any(isinstance(each, ast.Constant) for pair in pairs for each in pair.comparators)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_says_what_one_sees_and_checks_it(path):
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    assert "You will see" in " ".join(ast.get_docstring(tree).split())
    assert is_check(tree.body[-1]), "it does not end with an assertion"
    assert compares(tree), "it compares with no number"
    lines = [line.strip() for line in text.splitlines()]
    assert len([line for line in lines if line and not line.startswith("#")]) <= LINES


def test_an_example_without_a_check_is_found():
    assert not is_check(ast.parse("print(1)").body[-1])
    assert not compares(ast.parse("assert done"))
    assert is_check(ast.parse("for i in a:\n    assert i < 1").body[-1])
