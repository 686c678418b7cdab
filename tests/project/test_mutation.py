"""The deliberate faults of tests/mutation are of the code as it is."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "tests/mutation"))
from faults import FAULTS  # noqa: E402


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.breaks)
def test_the_text_that_a_fault_replaces_is_there_once(fault):
    assert (PROJECT / fault.file).read_text(encoding="utf-8").count(fault.old) == 1
    assert all((PROJECT / file).exists() for file in fault.likely)
