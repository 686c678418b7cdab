"""Fixtures for all tests."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
import pytest
from control_point_sets import DEVICES, EVERYWHERE, KINDS_AND_DEGREES
from pairwise import few_with_each_value

from vtk_mls.engine import dispatch, opencl_engine
from vtk_mls.engine.launch.launcher import Launcher

_FEW_CASES = {}  # cases that run and all cases, by test


@pytest.fixture(params=KINDS_AND_DEGREES, ids=lambda k: f"{k[0]}{k[1]}")
def kind_and_degree(request):
    return request.param


@pytest.fixture(params=EVERYWHERE)
def device(request):
    """The specification, and each device."""
    return request.param


@pytest.fixture(params=DEVICES)
def key(request):
    """Each device."""
    return request.param


@pytest.fixture
def rng():
    return np.random.default_rng(20240229)


@pytest.fixture
def launched(monkeypatch):
    """The kernels that are launched: their names, and for how many points."""
    launches, launch = [], Launcher.launch

    def note(self, name, constants, count, *arguments):
        launches.append((name, count))
        launch(self, name, constants, count, *arguments)

    monkeypatch.setattr(Launcher, "launch", note)
    return launches


@pytest.fixture
def device_memory(monkeypatch):
    """The memory of a device that does not work in the host's."""
    memory = opencl_engine.on(dispatch.choose(DEVICES[0])).memory
    memory._resident.clear()
    monkeypatch.setattr(memory, "in_place", False)
    yield memory
    memory._resident.clear()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Leave all but a few cases of a test to `make matrix`: each value is in one of those few."""
    cases = defaultdict(list)
    for item in items:
        if hasattr(item, "callspec") and not item.get_closest_marker("matrix"):
            cases[item.nodeid.partition("[")[0]].append(item)
    for test, found in cases.items():
        rows = [item.callspec._idlist for item in found]
        few = few_with_each_value(rows)
        if len(few) < len(found):
            _FEW_CASES[test] = len(few), len(found)
        for number, item in enumerate(found):
            if number not in few:
                item.add_marker(pytest.mark.matrix)


def pytest_sessionfinish(session):
    """A worker of pytest-xdist collects, and tells the process that prints."""
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["few cases"] = _FEW_CASES


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """Take what a worker of pytest-xdist tells."""
    _FEW_CASES.update(getattr(node, "workeroutput", {}).get("few cases", {}))


def pytest_terminal_summary(terminalreporter):
    """Say loudly what was not tested, and why."""
    if _FEW_CASES and "not matrix" in terminalreporter.config.option.markexpr:
        ran, total = map(sum, zip(*_FEW_CASES.values()))
        tests = f"{len(_FEW_CASES)} tests" if len(_FEW_CASES) > 10 else ", ".join(_FEW_CASES)
        terminalreporter.write_line(
            f"{ran} of {total} cases of {tests}; all of them: `make matrix`", yellow=True
        )
    skipped = terminalreporter.stats.get("skipped", [])
    reasons = Counter(report.longrepr[2].replace("Skipped: ", "", 1) for report in skipped)
    if reasons:
        terminalreporter.section("LEFT OUT ON THIS MACHINE", sep="*", red=True, bold=True)
        for reason, count in reasons.items():
            terminalreporter.write_line(f"tests left out: {count}, because: {reason}", yellow=True)


@pytest.fixture(scope="session")
def distributions(tmp_path_factory):
    """The source distribution, and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder)]
    project = Path(__file__).resolve().parents[1]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (sdist,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    return sdist, wheel
