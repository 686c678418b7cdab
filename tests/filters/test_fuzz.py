"""Some random cases in child processes; `python tests/fuzz/run.py 10000` runs more."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
import run


@pytest.mark.matrix
def test_random_cases():
    assert run.run(0, 40) == {}
