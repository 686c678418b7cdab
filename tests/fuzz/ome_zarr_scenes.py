"""Random OME-Zarr with label images and an orientation, held against nibabel and numpy."""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from vtk_mls import INTERPOLATIONS, Deformation, Grid, Sampling, io
from vtk_mls.blocks import image_job as job
from vtk_mls.files.ome_zarr import open_image
from vtk_mls.vtk.arrays import ImageGeometry

_SHARE = 0.1  # of the cases
_SIDES = {"R": "left-to-right", "L": "right-to-left", "A": "posterior-to-anterior"}
_SIDES |= {"P": "anterior-to-posterior", "S": "inferior-to-superior", "I": "superior-to-inferior"}
_TO_LPS = np.diag([-1.0, -1, 1])


def check_ome_zarr(seed, device):
    """Image and labels are deformed as in memory, where nibabel sees them, and no label is new."""
    rng = np.random.default_rng([seed, 4])
    if rng.random() > _SHARE or not all(map(find_spec, ("zarr", "nibabel"))):
        return
    code, shape = _code(rng), tuple(rng.integers(3, 20, 3).tolist())
    grid = _grid(rng, code, shape)
    values = (1000 * rng.random(shape)).astype(rng.choice(["u1", "i2", "u4", "f4", "f8"]))
    labels = rng.choice([0, 3, 70, 200], shape).astype(rng.choice(["u1", "u2", "i4"]))
    is_sampled, has_own = rng.random() < 0.5, rng.random() < 0.5
    rest = grid.at(rng.uniform(0, 1, (5, 3)) * shape[::-1])
    moved = rest + rng.normal(0, 1, (5, 3)) * grid.spacing.min()
    d = Deformation(rest, moved, device="reference" if rng.random() < 0.5 else device)
    method = str(rng.choice(INTERPOLATIONS))
    settings = {"interpolation": method, "background": 3.0, "void_values": "background"}
    case = f"{code or 'no orientation'}, {shape} of {values.dtype}, {method}, sampled {is_sampled}"
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.ome.zarr"), Path(folder, "out.ome.zarr")
        _write(rng, source, values, grid, code, is_sampled)
        _write(rng, source / "labels/cells", labels, grid, code if has_own else "", is_sampled)
        job.deform(source, target, d, settings)
        (expected,) = d.resample([values], Sampling(grid, None, method, 3))
        (marked,) = d.resample([labels], Sampling(grid, None, "nearest", 3))
        for path, first in ((target, expected), (target / "labels/cells", marked)):
            image = open_image(path)
            np.testing.assert_array_equal(image.finest.array[...], first, err_msg=case)
            _check_place(image.finest.grid, grid, case)
            coarse = image.levels[1].array[...]
            if is_sampled:
                every = first[::2, ::2, ::2]
                np.testing.assert_array_equal(coarse, every, err_msg=case)
            assert path == target or {*coarse.flat} <= {*first.flat}, f"labels are new: {case}"
        image = io.read_dataset(target)
        _check_place(ImageGeometry.of_image(image).grid, grid, case)
        io.write_dataset(image, Path(folder, "out.nii"))
        _check_nifti(Path(folder, "out.nii"), expected, grid, code, case)


def _code(rng):
    """Where x, y and z grow to, as RAS; "" for a third of the files."""
    code = [str(rng.choice([*pair])) for pair in rng.permutation(["RL", "AP", "SI"])]
    return "".join(code) if rng.random() < 0.67 else ""


def _grid(rng, code, shape):
    import nibabel

    columns = np.zeros((3, 3))
    for axis, (row, sign) in enumerate(nibabel.orientations.axcodes2ornt(code or "LPS")):
        columns[int(row), axis] = sign
    columns = _TO_LPS @ columns
    origin = columns @ rng.normal(0, 50, 3).round(2)
    return Grid(shape[::-1], origin, rng.uniform(0.5, 3, 3).round(2), columns)


def _write(rng, path, values, grid, code, is_sampled):
    """Write two levels, the second of every second point, or as ngff-zarr places means."""
    import zarr

    is_old, coarse = rng.random() < 0.5, values[::2, ::2, ::2]
    file = zarr.open_group(path, mode="w", zarr_format=2 if is_old else 3)
    origin, sets = grid.origin @ grid.direction, []
    for name, level, factor in (("0", values, 1), ("1", coarse, 2)):
        shift = 0 if is_sampled else grid.spacing * (factor - 1) / 2
        scale = (grid.spacing * factor)[::-1].tolist()
        steps = [{"type": "scale", "scale": scale}]
        steps += [{"type": "translation", "translation": (origin + shift)[::-1].tolist()}]
        sets.append({"path": name, "coordinateTransformations": steps})
        chunks = tuple(int(rng.integers(2, n + 2)) for n in level.shape)
        file.create_array(name, data=level, chunks=chunks)
    axes = [{"name": name, "type": "space", "unit": "millimeter"} for name in "zyx"]
    for axis, letter in zip(axes, code[::-1]):
        form = {"type": "anatomical", "value": _SIDES[letter]}
        axis["orientation"] = form if rng.random() < 0.5 else form["value"]
    content = {"multiscales": [{"axes": axes, "datasets": sets}]}
    file.attrs.update(content if is_old else {"ome": {"version": "0.5", **content}})


def _check_place(found, expected, case):
    size = np.abs(expected.corners()).max()
    error = np.abs(found.corners() - expected.corners()).max()
    assert error <= 1e-9 * size, f"off by {error:g} of {size:g}: {case}"


def _check_nifti(path, values, grid, code, case):
    import nibabel

    file = nibabel.load(path)
    np.testing.assert_array_equal(np.asanyarray(file.dataobj).T, values, err_msg=case)
    affine = np.column_stack([grid.index_to_world, grid.origin])
    np.testing.assert_allclose(_TO_LPS @ file.affine[:3], affine, atol=1e-3, err_msg=case)
    assert "".join(nibabel.aff2axcodes(file.affine)) == (code or "LPS"), case
