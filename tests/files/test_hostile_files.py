"""Some broken files of every format; `hostile_files.py SEED COUNT` tries more."""

import os

import pytest
from command_fixtures import PROJECT, python

pytest.importorskip("resource", reason="memory cannot be limited here")
import hostile_files


@pytest.mark.parametrize("count", [80, pytest.param(250, marks=pytest.mark.matrix)])
def test_every_broken_file_is_deformed_or_ends_in_a_sentence(count, tmp_path):
    path = f"{PROJECT}{os.pathsep}{PROJECT / 'tests'}"
    arguments = hostile_files.__file__, 20240229, count
    status, out, err = python(*arguments, folder=tmp_path, path=path)
    assert status == 0, out + err
    assert "sentence" in out
    assert "deformed" in out
