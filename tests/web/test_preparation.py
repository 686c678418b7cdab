"""Kernels are built before other kinds and cuts are asked for."""

from __future__ import annotations

import asyncio

import pytest
from vtk_fixtures import FAST

from vtk_mls import kinds
from vtk_mls.editor import State
from vtk_mls.engine.launch.launcher import Launcher
from vtk_mls.web import preparation


def test_every_kind_comes_with_every_cut_the_own_first():
    wanted = [*preparation.maps("similarity", 3, 0, "reference")]
    found = [(each.kind, tuple(type(cut).__name__ for cut in each.cuts)) for each in wanted]
    assert len(set(found)) == len(found) == 4 * len(kinds.KINDS)
    assert {kind for kind, _ in found[:4]} == {"similarity"}
    assert {each.degree for each in wanted if each.kind == "polynomial"} == {3}


def test_it_tells_how_far_it_is():
    said = []
    asyncio.run(
        preparation.prepare(State([], [], device="reference"), lambda *each: said.append(each))
    )
    assert said == [(done, 16) for done in range(16)]


@pytest.mark.parametrize("tolerance", ["0.02", "0"])
def test_kernels_of_a_tolerance_are_built_too(tolerance, monkeypatch):
    launched, launch = set(), Launcher.launch

    def noted(self, name, *arguments):
        launched.add(name)
        launch(self, name, *arguments)

    def uncut(*arguments):
        return [each for each in maps(*arguments) if each.kind == "rigid" and not each.cuts]

    maps = preparation.maps
    monkeypatch.setattr(preparation, "maps", uncut)
    monkeypatch.setattr(preparation.os, "nice", lambda by: None, raising=False)
    monkeypatch.setattr(Launcher, "launch", noted)
    preparation.main("rigid", "2", tolerance, FAST)
    assert "grid_displacement" in launched
    assert ("coarse_displacement" in launched) == (tolerance != "0")
