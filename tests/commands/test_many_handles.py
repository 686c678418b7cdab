"""Very many control points by the command: within a tolerance, and not one by one."""

import nibabel
import numpy as np
import pytest
import SimpleITK as sitk
from vtk_fixtures import FAST

from vtk_mls.cli import main

COUNT, SIZE, VOXEL = 20_000, 24, 2.0
TOLERANCE = 0.02


@pytest.fixture
def scan(tmp_path, monkeypatch, rng):
    """scan.nii.gz, RAS, axes mirrored, of values that differ by 1 a voxel, and handles.csv."""
    monkeypatch.chdir(tmp_path)
    values = np.indices((SIZE,) * 3).sum(axis=0).astype(np.float32)
    affine = np.diag([-VOXEL, VOXEL, VOXEL, 1])
    affine[:3, 3] = 30, -25, -20
    nibabel.save(nibabel.Nifti1Image(values, affine), "scan.nii.gz")
    rest = rng.uniform([-30, -21, -20], [16, 25, 26], (COUNT, 3))  # its bounds in LPS
    wave = 2 * np.sin(rest[:, [1, 2, 0]] / 10)
    rows = np.hstack([rest, rest + wave + rng.normal(0, 0.1, rest.shape)])
    np.savetxt("handles.csv", rows, "%.6f", ",", header="px,py,pz,qx,qy,qz", comments="")


@pytest.mark.parametrize("kind", ["rigid", "affine"])
def test_many_handles_within_a_tolerance(scan, kind):
    found = {}
    for tolerance in (0, TOLERANCE):
        options = ["--kind", kind, "--map-tolerance", str(tolerance), "--device", FAST]
        assert main(["field", "scan.nii.gz", "handles.csv", "warp.nrrd", *options]) == 0
        assert main(["deform", "scan.nii.gz", "handles.csv", "bent.nii.gz", *options]) == 0
        warp = sitk.GetArrayFromImage(sitk.ReadImage("warp.nrrd"))
        found[tolerance] = warp, nibabel.load("bent.nii.gz").get_fdata().T
    (exact, values), (warp, near) = found.values()
    apart = np.linalg.norm(warp - exact, axis=-1) / VOXEL
    assert 1e-4 < apart.max() < TOLERANCE  # not the same: clusters have counted
    assert np.linalg.norm(exact, axis=-1).max() > VOXEL
    # three steps of 1, and what leaves the scan on one side alone
    inside = (slice(3, -3),) * 3
    assert np.abs(near - values)[inside].max() < 3**0.5 * TOLERANCE + 1e-4
