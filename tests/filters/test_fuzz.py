"""Some random cases in child processes; `python tests/fuzz/run.py 10000` runs more."""

import subprocess
import sys
from pathlib import Path

import pytest

FUZZ = Path(__file__).parents[1] / "fuzz"
sys.path.insert(0, str(FUZZ))
import run  # noqa: E402


@pytest.mark.matrix
def test_random_cases():
    assert run.run(0, 40) == {}


@pytest.mark.parametrize("fault", ["raise AssertionError('wrong')", "import os; os.abort()"])
def test_the_driver_says_which_case_failed(fault, tmp_path, monkeypatch):
    """Also if its process ends in the middle of it."""
    (tmp_path / "run.py").write_text((FUZZ / "run.py").read_text())
    checks = f"def check(seed, device):\n    if seed == 62:\n        {fault}\n"
    (tmp_path / "checks.py").write_text(checks)
    (tmp_path / "ome_zarr_scenes.py").write_text("def check_ome_zarr(seed, device): ...")
    command = [sys.executable, str(tmp_path / "run.py"), "70", "--first", "40"]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 1
    assert "70 cases, 1 failed" in ended.stdout
    assert "seed 62: " in ended.stdout
