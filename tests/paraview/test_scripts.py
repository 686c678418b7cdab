"""Scripts in all installed ParaViews: `check_*.py` and the example in pvpython, others by MPI."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import threading
from pathlib import Path

import pytest
from paraviews import NOISE, PICTURES, PROJECT, free_port, unavailable

SCRIPTS = sorted(
    path.relative_to(PROJECT)
    for pattern in ("tests/paraview/check_*.py", "examples/paraview_*.py")
    for path in PROJECT.glob(pattern)
)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_script(paraview, display, script, request):
    pictures = PICTURES / request.node.callspec.id.partition("-")[0]
    (PROJECT / pictures).mkdir(parents=True, exist_ok=True)
    paraview.check(script, pictures, display=display)


@pytest.mark.parametrize("script", ["exception.py", "vtk_error.py"])
def test_harness_can_fail(paraview, script):
    with pytest.raises(AssertionError, match=script):
        paraview.check(Path("tests/paraview/failing") / script)


MPI = Path("tests/paraview/mpi")
MPI_TIMEOUT = 300  # seconds
ROOT_MAY = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


@pytest.fixture
def start(paraview, display):
    """Start a program of ParaView in `count` processes; it ends with the test."""
    found = subprocess.run(
        [*paraview.prefix, "mpirun", "--version"], capture_output=True, check=False
    )
    if found.returncode:
        unavailable(f"no mpirun for {paraview.name}: package openmpi-bin")
    display_variables = {"DISPLAY": display} if display and not paraview.prefix else {}
    running = []

    def run(count, *command):
        many = ["mpirun", "--oversubscribe", "-np", str(count)] if count else []
        process = subprocess.Popen(
            [*paraview.prefix, *many, *map(str, command)],
            cwd=PROJECT,
            env=paraview.environment(**ROOT_MAY, **display_variables),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        running.append(process)
        return process

    yield run
    for process in running:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def finish(process):
    """The output of a process, which must succeed and print no error or warning."""
    try:
        output, _ = process.communicate(timeout=MPI_TIMEOUT)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        pytest.fail(f"not done after {MPI_TIMEOUT} s:\n{process.communicate()[0]}")
    noise = [line for line in output.splitlines() if NOISE.search(line)]
    assert (process.returncode, noise) == (0, []), output
    return output


@pytest.mark.matrix  # minutes; tests/filters/test_pieces.py asks for pieces in one process
@pytest.mark.parametrize("count", [1, 2, 4])
def test_pieces_are_the_whole(start, count):
    output = finish(start(count, "pvbatch", "--symmetric", MPI / "pieces.py"))
    done = re.findall(r"done (\d+) of (\d+)", output)
    assert sorted(done) == [(str(rank), str(count)) for rank in range(count)]


@pytest.mark.matrix  # the client runs the same script
def test_proxies_in_pvbatch(start):
    assert "done with 2" in finish(start(2, "pvbatch", MPI / "proxies.py"))


def test_a_client_of_pvserver(start):
    port = free_port()
    server = start(2, "pvserver", f"--server-port={port}")
    await_line(server, "Accepting connection")
    assert "done with 2" in finish(start(0, "pvpython", MPI / "proxies.py", port))


def await_line(process, words, seconds=60):
    """Read the output of a process up to a line with `words`."""
    too_long = threading.Timer(seconds, os.killpg, (process.pid, signal.SIGKILL))
    too_long.start()
    lines = []
    for line in process.stdout:
        lines.append(line)
        if words in line:
            too_long.cancel()
            return
    pytest.fail(f"no `{words}` in:\n{''.join(lines)}")
