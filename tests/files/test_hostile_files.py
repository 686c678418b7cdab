"""Some broken files of every format; `hostile_files.py SEED COUNT` tries more."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("resource", reason="memory cannot be limited here")
import hostile_files


@pytest.mark.parametrize("count", [80, pytest.param(250, marks=pytest.mark.matrix)])
def test_every_broken_file_is_deformed_or_ends_in_a_sentence(count, tmp_path):
    command = [sys.executable, hostile_files.__file__, "20240229", str(count)]
    project = Path(hostile_files.__file__).parents[2]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": f"{project}{os.pathsep}{project / 'tests'}"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "sentence" in done.stdout
    assert "deformed" in done.stdout
