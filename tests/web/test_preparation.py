"""Kernels of other kinds and cuts are built ahead."""

from __future__ import annotations

import pytest
from vtk_fixtures import FAST

from vtk_mls.editor import State
from vtk_mls.engine.launch.launcher import Launcher
from vtk_mls.model import kinds
from vtk_mls.web import preparation


def test_maps_of_all_kinds_and_cuts_the_current_kind_first():
    maps = [*preparation.maps("similarity", 3, 0, "reference")]
    pairs = [(map.kind, tuple(type(cut).__name__ for cut in map.cuts)) for map in maps]
    assert len(set(pairs)) == len(pairs) == 4 * len(kinds.KINDS)
    assert {kind for kind, _ in pairs[:4]} == {"similarity"}
    assert {map.degree for map in maps if map.kind == "polynomial"} == {3}


def test_progress():
    reports = []
    preparation.prepare(State([], [], device="reference"), lambda *report: reports.append(report))
    assert reports == [(done, 16) for done in range(16)]


@pytest.mark.parametrize("tolerance", [0.02, 0])
def test_kernels_of_a_tolerance_are_built_too(tolerance, monkeypatch):
    launched, launch = set(), Launcher.launch

    def note(self, name, *arguments):
        launched.add(name)
        launch(self, name, *arguments)

    def uncut(*arguments):
        return [map for map in maps(*arguments) if map.kind == "rigid" and not map.cuts]

    maps = preparation.maps
    monkeypatch.setattr(preparation, "maps", uncut)
    monkeypatch.setattr(preparation.os, "nice", lambda by: None, raising=False)
    monkeypatch.setattr(Launcher, "launch", note)
    preparation.build(None, "rigid", 2, tolerance, FAST)
    assert "grid_displacement" in launched
    assert ("coarse_displacement" in launched) == (tolerance != 0)
