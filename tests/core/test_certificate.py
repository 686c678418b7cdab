"""Certificates: voxels and tetrahedra that keep their orientation, against numpy."""

import sys
from pathlib import Path

import numpy as np
import pytest
from pairwise import paired, rare

from vtk_mls import Affine, BallMask, Chain, Deformation, DisplacementField, Grid, HalfPlane, Plane
from vtk_mls.queries import certificate, fold_free

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
import folds

TURNED = np.array([(0, 0, 1), (1, 0, 0), (0, 1, 0.0)])


def grid(n=20, direction=None):
    return Grid((n, n + 1, n - 1), (0, 0, 0), (1 / n,) * 3, direction)


def squeezed(factor=0.15):
    """A box of eight points, and eight inside that are squeezed."""
    box = np.array([(x, y, z) for x in (-55, 55) for y in (-55, 55) for z in (-55, 55)], float)
    return np.r_[box, box * 12 / 55], np.r_[box, box * 12 / 55 * factor]


@pytest.mark.parametrize("direction", [None, TURNED, np.diag([1.0, -1, 1])])
def test_voxels_are_those_with_a_negative_tetrahedron(device, direction, rng):
    where = grid(direction=direction)
    counts = []
    for amount in (0.01, 0.12):
        index = np.stack(np.meshgrid(*[(3, 10, 17)] * 3), axis=-1).reshape(-1, 3)
        p = where.at(index + rng.uniform(-1, 1, index.shape))
        d = Deformation(p, p + amount * rng.normal(size=p.shape), device=device)
        field = d.displacement_field(where)
        proof = d.certificate(where)
        expected = np.flatnonzero(folds.negative_tetrahedra(field))
        np.testing.assert_array_equal(proof.indices, expected)
        np.testing.assert_array_equal(d.certificate(field).indices, expected)
        assert proof.is_proven == (len(expected) == 0)
        assert proof.checked == where.cells.size
        determinants = np.linalg.det(d.jacobian(where.cells.points()))
        in_map = np.flatnonzero(determinants <= 0)
        assert len(np.setdiff1d(in_map, proof.map_indices)) <= 0.01 * len(in_map)
        assert (len(in_map) == 0) == (len(proof.map_indices) == 0)
        counts.append(proof.folded)
    assert counts[0] == 0 < counts[1]
    assert "proven to keep orientation in all 7600 voxels" not in str(proof)
    assert f"folds in {counts[1]} of {where.cells.size} voxels" in str(proof)


def test_a_finer_spacing_that_does_not_fold_is_named():
    """The map keeps orientation, but bends between the points of the grid."""
    rng = np.random.default_rng(4)
    p = 0.5 + 0.02 * rng.normal(size=(3, 3))
    p = np.r_[p, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]]
    q = p.copy()
    q[:3] = 0.5 + (p[:3] - 0.5) @ folds.rotation(rng, 2.0).T
    d = Deformation(p, q, steps=64)
    where = Grid((12,) * 3, (0, 0, 0), (1 / 11,) * 3)
    proof = d.certificate(where)
    assert proof.folded > 0 == len(proof.map_indices)
    assert proof.spacing is not None
    count = round(1 / 11 / proof.spacing[0])
    assert count in (2, 4, 8)
    finer = [Grid((11 * n + 1,) * 3, (0, 0, 0), (1 / 11 / n,) * 3) for n in (count // 2, count)]
    assert [d.certificate(g).is_proven for g in finer] == [False, True]
    assert "a field with the spacing" in str(proof)


def test_a_map_that_folds_needs_steps_and_no_spacing():
    d = Deformation(*squeezed())
    proof = d.certificate(Grid((40,) * 3, (-20,) * 3, (1.0,) * 3))
    assert len(proof.map_indices) > 0
    assert proof.spacing is None
    assert "which more steps may avoid" in str(proof)


@pytest.mark.parametrize("cut", [Plane((0.5, 0.5, 0.5), (1, 0.3, 0)), "half-plane"])
@pytest.mark.parametrize("frame", ["rest", "deformed"])
@pytest.mark.parametrize("apart", [-0.1, 0.1])
def test_voxels_across_a_cut_are_left_out(cut, frame, apart, rng):
    """The sides slide along the cut, and the void between them opens or stays closed."""
    if cut == "half-plane":
        cut = HalfPlane((0.5, 0.5, 0.5), (1, 0.3, 0), (0, 0, 1))
    p = rng.random((20, 3))
    side = np.sign((p - 0.5) @ (1, 0.3, 0))
    q = p + side[:, None] * [max(apart, 0), 0.1, 0]
    where = grid()
    plain, whole = (
        Deformation(p, q, cuts=cuts, cut_frame=frame, device="reference").certificate(where)
        for cuts in (cut, ())
    )
    assert whole.left_out == 0 < plain.left_out
    assert plain.checked + plain.left_out == where.cells.size
    assert f"without {plain.left_out} across a cut or void" in str(plain)
    if isinstance(cut, Plane):
        assert plain.is_proven, str(plain)


def test_tetrahedra(device, rng):
    points = grid(4).points()
    cells = np.array([(0, 1, 4, 20), (21, 22, 26, 41), (40, 41, 45, 20)], np.uint8)
    for amount, count in ((0.0, 0), (1.0, 3)):
        p = rng.random((15, 3))
        q = p * [1, 1, 1 - 1.5 * amount]  # a mirror
        d = Deformation(p, q, "affine", device=device)
        proof = d.certificate((points, cells))
        assert (proof.folded, proof.checked) == (count, 3)
        assert "3 tetrahedra" in str(proof)
    sentence = r"`where\[1\]` must .*(\(m, 4\)|of the 60 `points`|integers)"
    for wrong in (cells[:, :3], cells + 19, cells - np.array(1), cells / 2):
        with pytest.raises((TypeError, ValueError), match=sentence):
            d.certificate((points, wrong))
    with pytest.raises(TypeError, match="`where` must be a Grid"):
        d.certificate(points)


def test_chains_have_certificates(rng):
    p = rng.random((12, 3))
    d = Deformation(p, p + 0.12 * rng.normal(size=p.shape))
    where = grid()
    alone, chained = (t.certificate(where) for t in (d, Chain([Affine(np.eye(4)), d])))
    assert alone.folded > 0
    np.testing.assert_array_equal(chained.indices, alone.indices)
    assert Affine(np.diag([-1.0, 1, 1, 1])).certificate(where).folded == where.cells.size


def test_inverse_fields_have_certificates(rng):
    p, where, counts = rng.random((12, 3)), grid(), []
    for amount in (0.01, 0.1):
        d = Deformation(p, p + amount * rng.normal(size=p.shape), steps=16)
        displacement = d.forward_field(where.points()).displacement.reshape(*where.shape, 3)
        field = DisplacementField(displacement, where)
        proof = certificate.certificate_of_inverse(d, field)
        np.testing.assert_array_equal(
            proof.indices, np.flatnonzero(folds.negative_tetrahedra(field))
        )
        counts.append(proof.folded)
    assert counts[0] == 0 < counts[1]


def test_steps_are_raised_where_voxels_fold(monkeypatch, caplog):
    """With a first guess that looks nowhere, the check of the grid finds the folds."""
    monkeypatch.setattr(fold_free, "in_enough_steps", lambda _, d, *more: d.in_steps(1))
    where = Grid((40,) * 3, (-20,) * 3, (1.0,) * 3)
    image = np.zeros(where.shape, np.float32)
    questions = {
        "field": lambda d: d.displacement_field(where),
        "image": lambda d: d.resample([image], where),
        "gradient": lambda d: d.corrected_gradient(image, where),
        "Jacobian": lambda d: d.jacobian_field(where),
        "chain": lambda d: Chain([Affine(np.eye(4)), d]).resample([image], where),
        "field of a chain": lambda d: Chain([d]).displacement_field(where),
    }
    points = np.concatenate([where.points(), where.cells.points()])
    for name, ask in questions.items():
        d = Deformation(*squeezed(), steps="auto")
        assert d.steps_used == 1
        assert np.linalg.det(d.jacobian(points)).min() < 0
        ask(d)
        assert d.steps_used > 1, name
        determinants = np.linalg.det(d.jacobian(points))
        assert determinants.min() > 0
        assert d.smallest_determinant > 0
        given = Deformation(*squeezed(), steps=d.steps_used)
        expected = given.displacement_field(where).displacement
        np.testing.assert_array_equal(d.displacement_field(where).displacement, expected)
        assert np.abs(d.backward(d.deformed) - d.rest).max() < 1e-4
        found = d.forward_field(d.backward(points[::50]))
        assert found.found.all()
    assert not caplog.text


def test_parts_of_a_grid_keep_their_steps(monkeypatch):
    """So that they fit together; a deformation is the same for all of them."""
    monkeypatch.setattr(fold_free, "in_enough_steps", lambda _, d, *more: d.in_steps(1))
    where = Grid((40,) * 3, (-20,) * 3, (1.0,) * 3)
    d = Deformation(*squeezed(), steps="auto")
    half = where.part((0, 0, 0), (40, 40, 20))
    d.displacement_field(half)
    assert d.steps_used == 1
    folded = d._folded_points(half, certificate.SILENT)
    d.displacement_field(where)
    assert d.steps_used > 1
    plain = Deformation(*squeezed())
    whole = plain._folded_points(where, certificate.SILENT)
    np.testing.assert_array_equal(folded, whole[:20])
    assert folded.any()


def test_folds_that_remain_are_counted(caplog, monkeypatch):
    monkeypatch.setattr(fold_free, "in_enough_steps", lambda _, d, *more: d.in_steps(1))
    monkeypatch.setattr(fold_free, "MAX_STEPS", 2)
    where = Grid((40,) * 3, (-20,) * 3, (1.0,) * 3)
    d = Deformation(*squeezed(0.02), steps="auto")
    field = d.displacement_field(where)
    count = len(d.certificate(field).map_indices)
    assert f"The map folds in {count} of 59319 voxels, even in 2 steps" in caplog.text
    assert d.smallest_determinant <= 0


def test_the_first_guess_finds_folds_around_a_squeezed_cluster():
    d = Deformation(*squeezed(), steps="auto")
    v = np.random.default_rng(0).uniform(-8, 8, (6000, 3))
    assert d.steps_used >= 4
    assert np.linalg.det(d.jacobian(v)).min() > 0


def test_outside_of_a_mask_voxels_are_proven(rng):
    p = rng.random((12, 3))
    mask = BallMask((0.5, 0.5, 0.5), 0.2, 0.1)
    q = p + 0.1 * rng.normal(size=p.shape)
    d = Deformation(p, q, mask=mask, steps="auto", device="reference")
    proof = d.certificate(grid())
    assert proof.left_out == 0
    centers = grid().cells.points()[proof.indices]
    assert np.linalg.norm(centers - 0.5, axis=1).max(initial=0) < 0.4


def test_flat_grids_are_checked_at_all_points():
    d = Deformation(*squeezed())
    flat = Grid((40, 40, 1), (-20, -20, -4), (1.0,) * 3)
    determinants = np.linalg.det(d.jacobian(flat.points()))
    folded = d._folded_points(flat, certificate.SILENT)
    assert 0 < (determinants <= 0).sum() <= folded.sum() < flat.size


@paired(kind=["rigid", "spline", *rare("affine", "similarity")], move=folds.MOVES)
def test_random_scenes_do_not_fold(kind, move):
    """tests/fuzz/folds.py examines more."""
    rng = np.random.default_rng([folds.KINDS.index(kind), folds.MOVES.index(move)])
    scene = folds.scene(rng, kind, move)
    scene.options["alpha"] = 2.0  # other tests build its kernels, too
    result = folds.examine(scene, n=24)
    assert result["map folds"] == result["not found by the check"] == 0
    assert result["differences"] > 0
    assert not result["certificate differs"]
    assert result["residual"] <= 1e-5
