"""Deforms OME-Zarr images in blocks, by threads of this process or by a dask cluster."""

import concurrent.futures
import functools
import os
import pickle
from contextlib import contextmanager, suppress
from pathlib import Path

import vtk_mls
from vtk_mls.base.messages import warn
from vtk_mls.base.progress import whole
from vtk_mls.base.sampling import Sampling
from vtk_mls.blocks.image_blocks import MAX_VALUES, DeformedBlocks, FieldBlocks, channel_backgrounds
from vtk_mls.blocks.unfinished import Unfinished, check_output, copy_metadata, hash_of
from vtk_mls.files.ome_zarr import LABELS, open_image, open_input, state_method

_PATIENCE = 10.0  # seconds without a block until the workers of a cluster are looked at
_MAX_THREADS = 4  # each holds a block: while one computes, others read and write
# Components of a displacement field.
_COMPONENTS = "x", "y", "z"
_IN_LPS = "to the left", "to posterior", "to superior"
_COLORS = "FF0000", "00FF00", "0000FF"


def deform(source, target, transform, settings, *, scheduler=None, progress=None):
    """Deform an image: all times, channels, resolutions and label images.

    `source` and `target` are folders; an interrupted `target` of the same inputs is resumed. The
    Transform is in the units of the file. `settings` are `interpolation` and `background` (of all
    channels, or of each; "auto" as of `channel_backgrounds`) and `void_values` of a `Sampling`;
    label images are sampled nearest. `scheduler` is the address of a dask.distributed scheduler,
    whose workers see the same folders.

    Returns whether work was resumed, as a sentence; "" if it was not. Errors (Aborted, DeviceError,
    OSError, ValueError) name the folder.
    """
    image = open_input(source)
    sampling = Sampling(image.finest.grid, **settings)
    methods = {*image.methods(settings["interpolation"])}
    images = {"": image}
    for name in image.labels:
        images[f"{LABELS}/{name}"] = open_image(Path(source, LABELS, name))
    paths = []
    for place, member in images.items():
        for index in range(1, len(member.levels)):
            member.windows(index)
        paths += [f"{place}/{level.path}".lstrip("/") for level in member.levels]
    check_output(target, [source])
    inputs = hash_of(source, paths, transform, settings, vtk_mls.__version__)
    sampling.warn_of_background(
        {place or "the image": member.finest.array.dtype for place, member in images.items()}
    )
    with Unfinished(target, inputs) as unfinished:
        copy_metadata(Path(source), unfinished.data, [*images, *paths])
        for place, member in images.items():
            is_nearest = member.is_label or (not place and methods == {"nearest"})
            state_method(unfinished.data / place, "nearest" if is_nearest else "mean")
        source, parts = Path(source).resolve(), []
        for place, member in images.items():
            background = channel_backgrounds(member, settings["background"])
            own = {**settings, "background": background}
            parts.append(DeformedBlocks(source / place, unfinished.data / place, transform, **own))
        return _run(parts, unfinished, scheduler, progress)


def write_field(source, target, transform, *, scheduler=None, progress=None):
    """Write the displacement field of a transform on the finest grid of an image.

    Parameters and errors are as of `deform`. The field has the axes c, z, y, x: components along
    x, y and z of LPS.
    """
    image = open_input(source)
    check_output(target, [source])
    inputs = hash_of(source, [], "field", image.finest.grid, transform, vtk_mls.__version__)
    with Unfinished(target, inputs) as unfinished:
        if not unfinished.done:
            _create_field(unfinished.data, image)
        parts = [FieldBlocks(Path(source).resolve(), unfinished.data, transform)]
        return _run(parts, unfinished, scheduler, progress)


def _create_field(folder, image):
    import zarr

    finest = image.finest
    version = finest.array.metadata.zarr_format
    group = zarr.open_group(folder, mode="w", zarr_format=version)
    space = image.axes.lstrip("tc")
    chunks = (finest.array.shards or finest.array.chunks)[-len(space) :]
    shape = finest.array.shape[-len(space) :]
    group.create_array(
        "0",
        shape=(3, *shape),
        chunks=(3, *(min(n, size) for n, size in zip(chunks, shape))),
        dtype="float32",
        chunk_key_encoding={"name": "v2", "separator": "/"} if version == 2 else None,
        dimension_names=None if version == 2 else ["c", *space],
    )
    group.attrs.update(_field_attributes(image, space, version))


def _field_attributes(image, space, version):
    grid, count = image.finest.grid, len(space)
    axes = [{"name": "c", "type": "channel"}, *image.space]
    is_oriented = any("orientation" in axis for axis in image.space)
    origin = grid.origin @ grid.direction  # along the axes of the file
    scale = [1.0, *grid.spacing[::-1].tolist()[-count:]]
    shift = [0.0, *origin[::-1].tolist()[-count:]]
    transforms = [{"type": "scale", "scale": scale}, {"type": "translation", "translation": shift}]
    multiscale = {
        "name": "displacement",
        "axes": axes,
        "datasets": [{"path": "0", "coordinateTransformations": transforms}],
    }
    window = {"min": -1.0, "max": 1.0, "start": -1.0, "end": 1.0}
    channels = [
        {"label": name, "color": color, "window": window, "active": True}
        for name, color in zip(_IN_LPS if is_oriented else _COMPONENTS, _COLORS)
    ]
    if version == 2:
        return {
            "multiscales": [{"version": "0.4", **multiscale}],
            "omero": {"version": "0.4", "channels": channels},
        }
    return {"ome": {"version": "0.5", "multiscales": [multiscale], "omero": {"channels": channels}}}


def _run(parts, unfinished, scheduler, progress):
    """Write all blocks that are not written, and finish the output."""
    if not scheduler:
        for part in parts:
            part.transform._engine  # noqa: B018  an error of the device, before all work
    job = pickle.dumps((os.urandom(8), parts))  # another job for each run: workers keep the last
    stages = _stages(parts)
    total = sum(map(len, stages))
    with whole(progress) as fraction, _executor(scheduler) as (executor, count, watch):
        finished = 0
        for number, stage in enumerate(stages):
            size = max(part.size(number) for part in parts if number < part.stages)
            if scheduler or size <= MAX_VALUES:
                at_once = count
            else:  # large shards share the memory of usual blocks
                at_once = max(1, min(count, _MAX_THREADS * MAX_VALUES // size))
            finished += sum(name in unfinished.done for name in stage)
            todo = [(name, *task) for name, task in stage.items() if name not in unfinished.done]
            for name in _completed(executor, at_once, job, todo, watch):
                unfinished.note(name)
                finished += 1
                fraction.report(min(finished / total, 1))
    unfinished.finish()
    if unfinished.is_resumed:
        return "an interrupted output was resumed"
    return "an interrupted output of other inputs was replaced" * unfinished.replaced_other


def _stages(parts):
    """Blocks of each stage: (image, stage, first index) by name."""
    return [
        {
            f"{number}/{stage}/{'.'.join(map(str, start))}": (number, stage, start)
            for number, part in enumerate(parts)
            if stage < part.stages
            for start in part.starts(stage)
        }
        for stage in range(max(part.stages for part in parts))
    ]


def _completed(executor, count, job, todo, watch):
    """Names of blocks, as they are written; `count` at a time. `watch` is called in long pauses."""
    todo, running = iter(todo), {}
    try:
        while True:
            while len(running) < count and (task := next(todo, None)):
                name, *arguments = task
                running[executor.submit(_write, job, *arguments)] = name
            if not running:
                return
            done, _ = concurrent.futures.wait(running, _PATIENCE, "FIRST_COMPLETED")
            if not done:
                watch()
            for future in done:
                _check(future)
                yield running.pop(future)
    finally:
        for future in running:
            future.cancel()


def _check(future):
    try:
        future.result()
    except concurrent.futures.CancelledError as error:
        raise OSError("the cluster has stopped; run the same again to resume") from error
    except Exception as error:
        if not type(error).__module__.startswith("distributed"):
            raise
        raise OSError(f"the cluster failed: {error}; run the same again to resume") from error


def _write(job, number, stage, start):
    part = _parts(job)[number]
    try:
        part.write(stage, start)
    except (OSError, RuntimeError, ValueError) as error:
        if isinstance(error, vtk_mls.DeviceError):
            raise
        raise ValueError(
            f"`{part.source}` could not be deformed at {start}: {error or type(error).__name__}"
        ) from error


@functools.lru_cache(1)
def _parts(job):
    """The blocks of a job; opened images are kept for the next block."""
    return pickle.loads(job)[1]


@contextmanager
def _executor(scheduler):
    """An executor, the number of blocks to submit at a time, and a function for long pauses."""
    if not scheduler:
        count = min(_MAX_THREADS, max(2, os.cpu_count() or 1))
        with concurrent.futures.ThreadPoolExecutor(count) as executor:
            yield executor, count, lambda: None
        return
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise OSError("`--scheduler` needs dask: pip install 'vtk-mls[zarr]'") from error
    try:
        client = distributed.Client(scheduler, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        raise OSError(f"`--scheduler {scheduler}` does not answer: {error}") from error
    with client:
        threads = sum(client.nthreads().values())
        if not threads:
            raise OSError(f"the scheduler `{scheduler}` has no workers")
        with client.get_executor(pure=False) as executor:
            yield executor, 2 * threads, _watch(client)


def _watch(client):
    """A function that warns once while a cluster has no workers."""
    is_told = False

    def watch():
        nonlocal is_told
        with suppress(OSError):  # its blocks fail when the scheduler does not come back
            has_none = not client.nthreads()
            if has_none and not is_told:
                warn(
                    "the cluster has no workers any more; waiting for new ones (Ctrl-C stops, and "
                    "the same command resumes)"
                )
            is_told = has_none

    return watch
