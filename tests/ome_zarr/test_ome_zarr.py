"""`vtk-mls deform` and `field` of OME-Zarr: all resolutions, metadata, interruptions, errors."""

import concurrent.futures
import json
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import ngff_zarr
import numpy as np
import pytest
import tensorstore
from zarr_images import HANDLES, ORIGIN, SHAPE, SPACING, files, halves, values, write

from vtk_mls import Aborted, Deformation, Grid, Sampling, io
from vtk_mls.base.messages import message_handlers
from vtk_mls.blocks import image_blocks as blocks
from vtk_mls.blocks import image_job as job
from vtk_mls.commands import view
from vtk_mls.commands.cli import main
from vtk_mls.editor import saving
from vtk_mls.queries import fold_free

GRID = Grid(SHAPE[::-1], ORIGIN[::-1], SPACING[::-1])
D = Deformation(HANDLES[:, :3], HANDLES[:, 3:], device="reference")
SETTINGS = {"interpolation": "linear", "background": 0.0, "void_values": "background"}
CHANNELS = [
    {"label": name, "color": color, "window": {"min": 0, "max": 9, "start": 0, "end": 9}}
    for name, color in (("cells", "FF0000"), ("nuclei", "00FF00"))
]


@pytest.fixture
def small_blocks(monkeypatch):
    monkeypatch.setattr(blocks, "MAX_VALUES", 6 * 8 * 10)


def opened(path, name):
    """An array by the library tensorstore."""
    driver = "zarr3" if Path(path, "zarr.json").exists() else "zarr"
    spec = {"driver": driver, "kvstore": {"driver": "file", "path": str(Path(path, name))}}
    return tensorstore.open(spec).result()


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_all_resolutions_times_and_channels(version, folder, rng, small_blocks, capsys):
    stored = values(rng, (2, 2))
    write("in.ome.zarr", halves(stored), version, axes="tczyx", omero={"channels": CHANNELS})
    assert main(["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr"]) == 0
    said = capsys.readouterr().out
    assert "26 x 20 x 12 points" in said
    corners = stored[0][:, ::11, ::19, ::25].reshape(2, 8)  # of each channel at the first time
    medians = np.percentile(corners, 50, axis=1, method="lower").tolist()
    assert "; background " in said
    sampling = Sampling(GRID, background=medians * 2)
    moved = D.resample([*stored.reshape(4, *SHAPE)], sampling)
    expected = halves(np.reshape(moved, stored.shape))
    for number, level in enumerate(expected):
        found = opened("out.ome.zarr", f"scale{number}").read().result()
        np.testing.assert_array_equal(found, level)
    names = {name for name in files(Path("in.ome.zarr")) if Path(name).name[0] in ".z"}
    for name in names:  # the same metadata: axes, units, channels, chunks and compression
        text, old = Path("out.ome.zarr", name).read_text(), Path("in.ome.zarr", name).read_text()
        assert json.loads(text) == json.loads(old)
    image = ngff_zarr.from_ngff_zarr("out.ome.zarr", validate=True).images[0]
    assert image.axes_units["x"] == "micrometer"
    assert (image.dims, image.translation["z"]) == (tuple("tczyx"), 5)
    assert sorted(path.name for path in folder.iterdir()) == [
        *("handles.csv", "in.ome.zarr", "out.ome.zarr"),
    ]


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_the_method_of_the_coarser_resolutions_is_stated(version, folder, rng):
    file = write("in.ome.zarr", halves(values(rng)), version)
    attributes = dict(file.attrs)
    entry = attributes.get("ome", attributes)["multiscales"][0]
    entry |= {"type": "gaussian", "metadata": {"method": "filter", "version": "1"}, "name": "a"}
    file.attrs.update(attributes)
    assert main(["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr"]) == 0
    stated = ngff_zarr.from_ngff_zarr("out.ome.zarr", validate=True).metadata
    assert (stated.type, stated.metadata, stated.name) == ("mean", None, "a")


def test_a_large_shard_is_computed_in_parts_and_written_once(folder, rng, monkeypatch):
    levels = halves(values(rng), 2)
    file = write("in.ome.zarr", levels)
    for number, level in enumerate(levels):
        options = {"chunks": (3, 4, 5), "shards": (6, 8, 10), "dimension_names": [*"zyx"]}
        file.create_array(f"scale{number}", data=level, overwrite=True, **options)
    monkeypatch.setattr(blocks, "MAX_VALUES", 70)
    monkeypatch.setattr(job, "MAX_VALUES", 70)
    sizes, written = [], []
    compute, write_values = blocks.DeformedBlocks._values, blocks.write

    def computed(self, stage, place):
        result = compute(self, stage, place)
        sizes.append(result.size)
        return result

    def write_once(array, place, result):
        written.append((array.path, str(place)))
        write_values(array, place, result)

    monkeypatch.setattr(blocks.DeformedBlocks, "_values", computed)
    monkeypatch.setattr(blocks, "write", write_once)
    assert main(["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr", "--background=0"]) == 0
    assert max(sizes) <= 70
    assert len(written) == len(set(written)) == 2 * 3 * 3 + 1 * 2 * 2
    (moved,) = D.resample([levels[0]], GRID)
    for number, level in enumerate(halves(moved, 2)):
        found = opened("out.ome.zarr", f"scale{number}").read().result()
        np.testing.assert_array_equal(found, level)


def test_the_displacement_field(folder, rng, small_blocks):
    for version in ("0.4", "0.5"):
        shutil.rmtree("in.ome.zarr", ignore_errors=True)
        write("in.ome.zarr", [values(rng)], version)
        assert main(["field", "in.ome.zarr", "handles.csv", "field.ome.zarr"]) == 0
        field = D.displacement_field(GRID).displacement
        found = opened("field.ome.zarr", "0").read().result()
        np.testing.assert_array_equal(np.moveaxis(found, 0, -1), field)
        image = ngff_zarr.from_ngff_zarr("field.ome.zarr", validate=True).images[0]
        assert (image.scale["z"], image.translation["x"], image.axes_units["y"]) == (
            *(4, 3, "micrometer"),
        )


def test_automatic_steps_are_those_of_the_whole_grid(folder, rng, small_blocks, monkeypatch):
    monkeypatch.setattr(fold_free, "in_enough_steps", lambda _, d, *more: d.in_steps(1))
    write("in.ome.zarr", [values(rng)])
    rest = GRID.at(rng.uniform(0, 1, (12, 3)) * np.subtract(GRID.dimensions, 1))
    deformed = rest + 0.15 * np.ptp(rest, axis=0) * rng.normal(size=rest.shape)
    np.savetxt("wild.csv", np.c_[rest, deformed], delimiter=",")
    command = ["field", "in.ome.zarr", "wild.csv", "field.ome.zarr", "--steps", "auto"]
    assert main([*command, "--kind", "rigid"]) == 0
    d = Deformation(rest, deformed, steps="auto")
    field = d.displacement_field(GRID).displacement
    assert d.steps_used > 1
    found = opened("field.ome.zarr", "0").read().result()
    np.testing.assert_array_equal(np.moveaxis(found, 0, -1), field)


def test_a_field_that_is_not_finite_is_an_error(folder, rng, refused):
    write("in.ome.zarr", [values(rng)[:3, :4, :5]])
    q = rng.uniform(0, 1, (30, 3))  # far from the image, where the map explodes
    np.savetxt("far.csv", np.hstack([q + rng.normal(0, 0.3, q.shape), q]), delimiter=",")
    options = ["--kind=polynomial", "--degree=2", "--steps=64"]
    error = refused("field", "in.ome.zarr", "far.csv", "field.ome.zarr", *options)
    assert "displacements are not finite (NaN or infinite)" in error
    assert not Path("field.ome.zarr").exists()


JOB = """
import sys, time
from pathlib import Path
from vtk_mls import Deformation
from vtk_mls.blocks import image_blocks as blocks, image_job as job
import numpy as np
blocks.MAX_VALUES = 6 * 8 * 10
handles = np.loadtxt("handles.csv", delimiter=",")
d = Deformation(handles[:, :3], handles[:, 3:], device="reference")

def wait(fraction):
    while fraction > 0.4 and Path("wait").exists():
        Path("waits").touch()
        time.sleep(0.05)

try:
    job.deform("in.ome.zarr", "out.ome.zarr", d, {settings!r}, progress=wait)
except OSError as error:
    sys.exit(str(error))
"""


def start():
    """A process that deforms in.ome.zarr; it stops in the middle while there is a file `wait`."""
    code = JOB.format(settings=SETTINGS)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, "-c", code], **pipes)


def kill(process):
    """Kill a process that stops in the middle."""
    while not Path("waits").exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    Path("wait").unlink()


def test_a_killed_process_is_resumed_to_the_same_files(folder, rng, small_blocks, monkeypatch):
    write("in.ome.zarr", halves(values(rng)))
    job.deform("in.ome.zarr", "whole.ome.zarr", D, SETTINGS)
    Path("wait").touch()
    kill(start())
    assert not Path("out.ome.zarr").exists(), "an unfinished output has another name"
    (place,) = Path("out.ome.zarr.unfinished").glob("*/scale0/c/0/0")
    remains = place / "0.12ab.partial"
    remains.write_bytes(b"half of a chunk")
    count, run = [], blocks.DeformedBlocks.write
    monkeypatch.setattr(blocks.DeformedBlocks, "write", lambda *a: count.append(run(*a)))
    D.backward(HANDLES[:, :3])  # what it keeps for later makes no other input of it
    text = job.deform("in.ome.zarr", "out.ome.zarr", D, SETTINGS)
    assert text == "an interrupted output was resumed"
    total = 2 * 3 * 3 + 2 * 2 + 1
    assert 3 <= len(count) <= total * 0.6 + 3, "just the blocks that were missing are computed"
    assert files(Path("out.ome.zarr")) == files(Path("whole.ome.zarr"))
    assert not Path("out.ome.zarr.unfinished").exists()


def test_one_job_at_a_time_writes_an_output(folder, rng, small_blocks):
    write("in.ome.zarr", halves(values(rng)))
    job.deform("in.ome.zarr", "whole.ome.zarr", D, SETTINGS)
    whole = files(Path("whole.ome.zarr"))
    Path("wait").touch()
    first = start()
    while not Path("waits").exists():
        time.sleep(0.05)
    second = start()
    sentence = "out.ome.zarr` could not be written: another job is writing it; wait for that"
    assert sentence in second.communicate()[1]
    with pytest.raises(OSError, match=sentence):  # also a job of other inputs
        job.write_field("in.ome.zarr", "out.ome.zarr", D)
    kill(first)
    assert not Path("out.ome.zarr").exists()
    assert job.deform("in.ome.zarr", "out.ome.zarr", D, SETTINGS).endswith("was resumed")
    assert files(Path("out.ome.zarr")) == whole
    for pause in (0, 0.2, 0.4):
        shutil.rmtree("out.ome.zarr")
        jobs = []
        for _ in range(2):
            jobs.append(start())
            time.sleep(pause)
        said = [running.communicate()[1].strip() for running in jobs]
        assert "" in said
        assert all(re.search("^$|another job (is writing|has just written) it", s) for s in said)
        assert files(Path("out.ome.zarr")) == whole
        assert not Path("out.ome.zarr.unfinished").exists()


def test_other_inputs_start_anew(folder, rng, small_blocks):
    write("in.ome.zarr", halves(values(rng)))
    other = Deformation(HANDLES[:, :3], HANDLES[:, 3:] + 1, device="reference")
    with pytest.raises(Aborted):
        job.deform("in.ome.zarr", "out.ome.zarr", other, SETTINGS, progress=lambda f: f > 0.4)
    text = job.deform("in.ome.zarr", "out.ome.zarr", D, SETTINGS)
    assert text == "an interrupted output of other inputs was replaced"
    job.deform("in.ome.zarr", "whole.ome.zarr", D, SETTINGS)
    assert files(Path("out.ome.zarr")) == files(Path("whole.ome.zarr"))
    with pytest.raises(Aborted):
        job.deform("in.ome.zarr", "out.ome.zarr", D, SETTINGS, progress=lambda f: f > 0.4)
    assert files(Path("out.ome.zarr")) == files(Path("whole.ome.zarr")), "the old one stays"
    write("in.ome.zarr", halves(values(rng)))
    text = job.deform("in.ome.zarr", "out.ome.zarr", D, SETTINGS)
    assert text == "an interrupted output of other inputs was replaced"


def test_workers_of_a_cluster_write_the_same_files(folder, rng, small_blocks):
    import distributed

    write("in.ome.zarr", halves(values(rng)))
    job.deform("in.ome.zarr", "whole.ome.zarr", D, {**SETTINGS, "background": "auto"})
    options = {"processes": False, "dashboard_address": None, "threads_per_worker": 1}
    with distributed.LocalCluster(2, protocol="tcp", host="127.0.0.1", **options) as cluster:
        command = ["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr"]
        assert main([*command, "--scheduler", cluster.scheduler_address]) == 0
    assert files(Path("out.ome.zarr")) == files(Path("whole.ome.zarr"))


def test_a_cluster_without_workers_is_reported_and_goes_on_with_new_ones(
    folder, rng, small_blocks, monkeypatch
):
    import distributed

    write("in.ome.zarr", halves(values(rng)))
    job.deform("in.ome.zarr", "whole.ome.zarr", D, SETTINGS)
    monkeypatch.setattr(job, "_PATIENCE", 0.5)
    said, workers = [], []

    def add_worker():
        module = "distributed.cli.dask_worker"
        options = ["--no-nanny", "--no-dashboard", "--nthreads", "1"]
        command = [sys.executable, "-m", module, address, *options]
        workers.append(subprocess.Popen(command, stderr=subprocess.DEVNULL))

    def told(sentence):
        said.append(sentence)
        add_worker()

    def stop(fraction):
        if fraction > 0.3 and len(workers) == 1:
            workers[0].kill()  # SIGKILL
            workers[0].wait()

    options = {"protocol": "tcp", "host": "127.0.0.1", "dashboard": False}
    scheduler = {"cls": distributed.Scheduler, "options": options}
    with distributed.SpecCluster({}, scheduler) as cluster:
        address = cluster.scheduler_address
        add_worker()
        with distributed.Client(address) as client:
            client.wait_for_workers(1)
        with message_handlers(None, told):
            arguments = "in.ome.zarr", "out.ome.zarr", D, SETTINGS
            job.deform(*arguments, scheduler=address, progress=stop)
        workers[-1].kill()
        workers[-1].wait()
    (sentence,) = said
    assert sentence.startswith("the cluster has no workers any more; waiting for new ones")
    assert files(Path("out.ome.zarr")) == files(Path("whole.ome.zarr"))


def test_a_cluster_that_stops_is_one_sentence():
    future = concurrent.futures.Future()
    future.cancel()
    with pytest.raises(OSError, match="the cluster has stopped; run the same again to resume"):
        job._check(future)


def test_a_flat_image_and_other_commands(folder, rng):
    stored = values(rng)[0]
    write("in.zarr", [stored], axes="yx")
    assert main(["deform", "in.zarr", "handles.csv", "out.zarr"]) == 0
    grid = Grid((*SHAPE[:0:-1], 1), (*ORIGIN[:0:-1], 0), (*SPACING[:0:-1], 1))
    (moved,) = D.resample([stored[None]], Sampling(grid, background="auto"))
    np.testing.assert_array_equal(opened("out.zarr", "scale0").read().result(), moved[0])
    image = io.read_dataset("out.zarr")  # as all images
    assert image.GetDimensions() == (26, 20, 1)
    assert image.GetPointData().GetScalars().GetName() == "OME-Zarr"
    assert main(["deform", "in.zarr", "handles.csv", "out.nii.gz"]) == 0


def test_one_time_is_requested_where_one_is_needed(folder, rng, refused):
    write("in.ome.zarr", [values(rng, (2,))], axes="tzyx")
    for command in ("deform", "field"):
        error = refused(command, "in.ome.zarr", "handles.csv", "out.nii.gz")
        assert "it has 2 times, expected one; only `vtk-mls deform`" in error
        assert main([command, "in.ome.zarr", "handles.csv", "out.ome.zarr"]) == 0
        shutil.rmtree("out.ome.zarr")


def test_the_editor_shows_a_level_that_fits_and_saves_all(folder, rng, monkeypatch):
    stored = halves(values(rng))
    write("in.ome.zarr", stored)
    datasets_shown = []

    def show(datasets, state, paths, folder, *_):
        saver = saving.Saver(datasets, paths)
        saver.folder, saver.progress = Path(folder), datasets_shown.append
        saver.save(state, None)
        datasets_shown.append(datasets[0])

    monkeypatch.setattr(saving.vtk_io, "write_png", lambda *_: None)
    monkeypatch.setattr("vtk_mls.editor.window.show", show)
    monkeypatch.setattr(view, "MAX_POINTS", 1000)
    assert main(["view", "in.ome.zarr", "handles.csv", "--window", "--output", "saved"]) == 0
    *fractions, dataset = datasets_shown
    assert dataset.GetDimensions() == (13, 10, 6)
    np.testing.assert_allclose(dataset.GetSpacing(), 2 * np.array(SPACING[::-1]))
    np.testing.assert_allclose(dataset.GetOrigin(), np.add(ORIGIN, np.array(SPACING) / 2)[::-1])
    assert fractions == sorted(fractions)
    (moved,) = D.resample([stored[0]], Sampling(GRID, background="auto"))
    for number, level in enumerate(halves(moved)):
        found = opened("saved/in-deformed.ome.zarr", f"scale{number}").read().result()
        np.testing.assert_array_equal(found, level)
    shutil.rmtree("saved/in-deformed.ome.zarr")
    subprocess.run([sys.executable, "saved/deform.py"], check=True, capture_output=True)
    assert Path("saved/in-deformed.ome.zarr/zarr.json").is_file()


def metadata(change):
    """A function of a folder that changes the metadata of its image."""

    def apply(folder):
        file = folder / "zarr.json"
        content = json.loads(file.read_text())
        change(content["attributes"]["ome"]["multiscales"][0])
        file.write_text(json.dumps(content))

    return apply


def truncate(name):
    def apply(folder):
        file = folder / name
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])

    return apply


BROKEN = {
    "no group": (lambda folder: (folder / "zarr.json").unlink(), "is not a readable OME-Zarr"),
    "truncated": (truncate("zarr.json"), "is not a readable OME-Zarr: "),
    "array": (truncate("scale1/zarr.json"), "is not a readable OME-Zarr: "),
    "chunk": (truncate("scale0/c/0/1/0"), "in.ome.zarr` could not be deformed at "),
    "axes": (metadata(lambda m: m["axes"].reverse()), "its axes must be t, c, z, y, x in this"),
    "count": (metadata(lambda m: m["axes"].pop(0)), "array `scale0` must have the axes yx, got 3"),
    "units": (
        metadata(lambda m: m["axes"][0].update(unit="pixel")),
        "must have units of length, got micrometer, pixel",
    ),
    "missing": (metadata(lambda m: m.pop("axes")), "not a readable OME-Zarr: KeyError 'axes'"),
    "empty": (metadata(lambda m: m["datasets"].clear()), "it has no resolutions"),
    "order": (metadata(lambda m: m["datasets"].reverse()), "its finest resolution must be the fir"),
    "scale": (
        metadata(
            lambda m: m["datasets"][0]["coordinateTransformations"][0].update(scale=[1, 0, 2])
        ),
        "scales of `scale0` must be positive, got .1.0, 0.0, 2.0",
    ),
    "kind": (
        metadata(lambda m: m["datasets"][0]["coordinateTransformations"][0].update(type="affine")),
        "must be scales and translations, got 'affine'",
    ),
    "ratio": (
        metadata(
            lambda m: m["datasets"][1]["coordinateTransformations"][0].update(scale=[3, 3, 3])
        ),
        r"level `scale1` must be coarser than the one before and in .*steps of .0.75, 1.5, 1.0",
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_files_are_one_sentence(case, folder, rng, capfd):
    write("in.ome.zarr", halves(values(rng)))
    change, sentence = BROKEN[case]
    change(Path("in.ome.zarr"))
    assert main(["deform", "in.ome.zarr", "handles.csv", "out.ome.zarr"]) == 1
    message = capfd.readouterr().err
    assert re.search(sentence, message), message
    assert len(message.strip().split("\n")) == 1
    assert not Path("out.ome.zarr").exists()


def test_refused_inputs_and_outputs(folder, rng, refused):
    write("in.ome.zarr", [values(rng)])
    Path("some.zarr").mkdir()
    (folder / "in.vti").touch()
    for (source, target), sentence in {
        ("in.ome.zarr", "some.zarr"): "it exists and is not an OME-Zarr",
        ("in.ome.zarr", "none/out.zarr"): "there is no folder",
        ("none.zarr", "out.zarr"): "does not exist; expected the folder of an OME-Zarr",
        ("in.vti", "out.zarr"): "can be made of an OME-Zarr only",
    }.items():
        assert sentence in refused("deform", source, "handles.csv", target)
