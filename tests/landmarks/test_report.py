"""The report on pairs of landmarks: errors when left out, outliers, swaps, settings, the volume."""

import json
from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import random_rotation, slopes
from landmark_pairs import planted_pairs, smooth_warp
from measure_report import found_faults, ratios

from vtk_mls import Deformation
from vtk_mls.base.linear_algebra import fitted_affine
from vtk_mls.landmarks import Settings, left_out, report
from vtk_mls.landmarks.left_out import PointPairs, predictions
from vtk_mls.landmarks.text import heading, page
from vtk_mls.landmarks.volume import Shape
from vtk_mls.model.kinds import splines

DEVICE = "reference"


def _by_brute_force(p, q, settings, weights=None):
    """The error of each pair by a deformation of all others."""
    errors = []
    for i in range(len(p)):
        others = np.arange(len(p)) != i
        factors = None if weights is None else weights[others]
        value = Deformation(
            p[others], q[others], weights=factors, device=DEVICE, **settings.options
        )
        errors.append(np.linalg.norm(value.backward(q[i : i + 1])[0] - p[i]))
    return np.array(errors)


@pytest.fixture
def pairs(rng):
    """p and q of 40 pairs, two of them swapped."""
    return planted_pairs(rng, 40)[:2]


@pytest.fixture(scope="module")
def found():
    """A report on 40 pairs with weights, the pairs and the weights."""
    rng = np.random.default_rng(3)
    p, q, _, _ = planted_pairs(rng, 40)
    weights = rng.uniform(0.5, 2, 40)
    return report(p, q, weights=weights, device=DEVICE), p, q, weights


def test_errors_and_medians_are_those_of_brute_force(found):
    value, p, q, weights = found
    expected = _by_brute_force(p, q, value.recommended, weights)
    np.testing.assert_allclose(value.error, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(value.moved, np.linalg.norm(p - q, axis=1), rtol=1e-12)
    scores, good = {}, ~value.outlier
    for settings in value.tried:
        errors = _by_brute_force(p[good], q[good], settings, weights[good])
        assert value.tried[settings] == pytest.approx(np.median(errors), abs=1e-9)
        scores[settings] = np.log(errors + 1e-3 * np.median(errors)).mean()
    assert value.recommended == min(scores, key=scores.__getitem__)


def test_the_baseline_is_one_map_for_all(pairs):
    value = report(*pairs, device=DEVICE)
    p, q = (places[~value.outlier] for places in pairs)
    affine, rigid = [], []
    for i in range(len(p)):
        others = np.arange(len(p)) != i
        matrix, offset = fitted_affine(q[others], p[others])
        affine.append(np.linalg.norm(matrix @ q[i] + offset - p[i]))
        means = p[others].mean(axis=0), q[others].mean(axis=0)
        left, _, right = np.linalg.svd((p[others] - means[0]).T @ (q[others] - means[1]))
        rotation = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
        rigid.append(np.linalg.norm(rotation @ (q[i] - means[1]) + means[0] - p[i]))
    assert value.baseline["affine"] == pytest.approx(np.median(affine), abs=1e-9)
    assert value.baseline["rigid"] == pytest.approx(np.median(rigid), abs=1e-9)


def test_a_pair_without_which_the_others_are_flat():
    rng = np.random.default_rng(5)
    q = rng.uniform(-80, 80, (40, 3))
    q[1:, 2] = 0
    q[0, 2] = 60
    p = smooth_warp(rng)(q)
    settings = Settings("affine", None, 2.0)
    rows = np.arange(len(q))
    predicted = predictions(PointPairs(p, q, np.ones(len(q))), rows, settings)
    errors = np.linalg.norm(predicted - p, axis=1)
    np.testing.assert_allclose(errors, _by_brute_force(p, q, settings), rtol=0, atol=1e-9)


def test_planted_faults_are_found_and_few_good_pairs_accused():
    # 100 sets: `python tests/landmarks/measure_report.py`
    complete, swaps, accused = found_faults(range(8))
    assert complete >= 7
    assert swaps >= 7
    assert accused <= 0.02


def test_clean_pairs_are_not_accused():
    rng = np.random.default_rng(1)
    q = rng.uniform(-80, 80, (60, 3))
    p = smooth_warp(rng)(q) + rng.normal(0, 0.5, q.shape)
    value = report(p, q, device=DEVICE)
    assert value.outlier.sum() <= 2
    assert value.swaps == []


def test_exact_pairs_are_not_accused(rng):
    p = rng.uniform(0, 100, (400, 3))
    q = p + 3 * np.sin(np.roll(p, 1, axis=1) / 20)
    value = report(p, q, device=DEVICE)
    assert value.outlier.mean() <= 0.02
    # pairs that are off by a tenth of their distances are found
    off = rng.choice(400, 4, replace=False)
    q[off] += (1, 0.5, 0.5)
    pairs = PointPairs(p, q, np.ones(400))
    assert left_out.find_outliers(pairs, value.recommended)[0][off].all()


def test_sparse_exact_pairs_are_not_accused():
    # their errors differ by the curvature of the map
    accused = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        q = rng.uniform(-80, 80, (60, 3))
        pairs = PointPairs(smooth_warp(rng)(q), q, np.ones(60))
        accused.append(
            left_out.find_outliers(pairs, Settings("spline", None, 0.0, 0.0, 3))[0].mean()
        )
    assert np.mean(accused) <= 0.02


def test_folds_only_beside_the_landmarks_are_distinguished(found):
    value = replace(found[0], smallest_determinant=-0.5, determinant_between=0.9)
    assert "folds, but not at samples between neighboring landmarks" in heading(value)[-1]
    value = replace(value, determinant_between=-0.1)
    assert "but not" not in heading(value)[-1]


def test_exact_translations_have_no_outliers(rng):
    q = rng.uniform(-80, 80, (12, 3))
    value = report(q + (3, 4, 0), q, device=DEVICE)
    np.testing.assert_allclose(value.error, 0, atol=1e-9)
    np.testing.assert_allclose(value.moved, 5)
    assert not value.outlier.any()


def test_recommended_settings_compare_with_a_spline():
    # r is the spline of 3-D; others and more pairs: `python tests/landmarks/measure_report.py`
    values = [ratios(seed, 60, 0.5)[1] for seed in range(3)]
    assert max(values) <= 1.3


def test_many_pairs_choose_by_a_sample(rng, monkeypatch):
    monkeypatch.setattr(splines, "_MAX_CHOSEN_FROM", 64)
    q = rng.uniform(-80, 80, (80, 3))
    p = smooth_warp(rng)(q) + rng.normal(0, 0.5, q.shape)
    q[0] += 30
    value = report(p, q, [f"pair {i}" for i in range(80)], device=DEVICE)
    assert value.sampled == 64
    assert value.outlier[0]
    assert value.outlier.mean() <= 0.02


def test_json_and_page(found):
    value, p, q, _ = found
    content = json.loads(json.dumps(value.as_dict()))
    assert [pair["name"] for pair in content["pairs"]] == [str(i + 1) for i in range(40)]
    assert {*content["pairs"][0]} == {
        *("name", "rest", "deformed", "moved", "error", "outlier", "swapped_with")
    }
    np.testing.assert_array_equal([pair["rest"] for pair in content["pairs"]], p)
    np.testing.assert_array_equal([pair["deformed"] for pair in content["pairs"]], q)
    (i, j), *_ = value.swaps
    assert content["pairs"][i]["swapped_with"] == str(j + 1)
    assert content["recommended"] in content["tried"]
    assert {*content["tried"][0]} == {
        *("kind", "degree", "alpha", "smoothing", "order", "softening", "median")
    }
    assert content["baseline"] == value.baseline
    rows = len(value.tried) + len(value.baseline) + 40
    assert page(value).count("<tr>") == rows + 2  # two heads


def test_names_in_the_page_are_text(pairs):
    names = ["<b>&", *(f"n{i}" for i in range(39))]
    text = page(report(*pairs, names, device=DEVICE))
    assert "&lt;b&gt;&amp;" in text
    assert "<b>&" not in text


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda p, q: (p[:3], q[:3]), r"must have at least 4 pairs .*, got 3"),
        (lambda p, q: (p[:5], q[:6]), r"must have the same number of points, got 5 and 6"),
        (lambda p, q: (p[[0, *range(8)]], q[:9]), r"`rest` must be distinct .* `1` and `2`"),
        (lambda p, q: (p[:9], q[[*range(8), 3]]), r"`deformed` must be distinct .* `4` and `9`"),
        (lambda p, q: (p * np.nan, q), r"`rest` must be finite"),
    ],
)
def test_wrong_pairs_are_one_sentence(pairs, change, sentence):
    with pytest.raises(ValueError, match=sentence):
        report(*change(*pairs), device=DEVICE)


@pytest.mark.parametrize("count", [4, 5, 7])
def test_few_pairs(rng, count):
    q = rng.uniform(-80, 80, (count, 3))
    p = smooth_warp(rng)(q)
    value = report(p, q, device=DEVICE)
    expected = _by_brute_force(p, q, value.recommended)
    np.testing.assert_allclose(value.error, expected, rtol=0, atol=1e-9)


# The volume around pairs: thin sets, mirrors, drags

Z = np.linspace(-160, 160, 18)


def _shape(p, q):
    return Shape.of(PointPairs(p, q, np.ones(len(p))))


def _spine(rng):
    p = np.c_[3 * np.sin(Z / 90), 12 * np.sin(Z / 110), Z]
    return p, p + np.c_[4 + 0 * Z, 6 * np.cos(Z / 100), 0.08 * Z] + rng.normal(0, 0.7, p.shape)


def _cord(rng):
    p = np.c_[0 * Z, 0 * Z, Z]
    return p, p + np.c_[4 + 0 * Z, 5 * np.cos(Z / 100), 0.08 * Z] + rng.normal(0, 0.7, p.shape)


def _slice(rng):
    p = np.c_[rng.uniform(-38, 38, (25, 2)), rng.normal(0, 0.3, 25)]
    wave = np.c_[3 * np.sin(p[:, 1] / 20), 2 * np.cos(p[:, 0] / 25)]
    return p, p + np.c_[wave, rng.normal(0, 0.3, 25)]


@pytest.mark.parametrize(("make", "name"), [(_spine, "line"), (_cord, "line"), (_slice, "plane")])
@pytest.mark.parametrize("turned", [False, True])
def test_maps_of_thin_sets_keep_the_volume_beside_them(make, name, turned):
    rng = np.random.default_rng(5)
    p, q = make(rng)
    matrix = random_rotation(rng) if turned else np.eye(3)
    p, q = p @ matrix, q @ matrix + 5 * turned
    value = report(p, q, device=DEVICE)
    assert f"nearly on a {name} (" in heading(value)[0]
    best = next(iter(value.tried))
    is_refused = best != value.recommended
    assert is_refused or name == "plane"
    assert (f"`{best.flags}` predicts best, but" in heading(value)[0]) == is_refused
    box = q.mean(axis=0) + np.ptp(q, axis=0).max() / 2 * rng.uniform(-1, 1, (300, 3))
    motion = q - p

    def sampled(settings):
        d = Deformation(p, q, device=DEVICE, **settings.options)
        moved = np.linalg.norm(d.backward(box) - box + motion.mean(axis=0), axis=1)
        return np.linalg.det(slopes(d, box, 1e-4)), np.quantile(moved, 0.85)

    largest = np.linalg.norm(motion - motion.mean(axis=0), axis=1).max()
    determinant, moved = sampled(value.recommended)
    assert np.mean((determinant > 0.1) & (determinant < 10)) > 0.85
    assert value.is_sensible
    assert moved < 3 * largest
    if is_refused:
        determinant, moved = sampled(best)
        assert np.mean((determinant > 0.1) & (determinant < 10)) < 0.5 or moved > 3 * largest


def test_pairs_without_a_sensible_map_are_reported(rng):
    p = np.c_[0 * Z, 0 * Z, Z] + rng.normal(0, 0.7, (18, 3))
    q = np.c_[0 * Z, 5 * np.cos(Z / 100), 1.05 * Z] + rng.normal(0, 0.7, (18, 3))
    value = report(p, q, device=DEVICE)  # their noise turns the map about the line
    assert not value.is_sensible
    assert any("no settings tried give a sensible map" in line for line in heading(value))


@pytest.mark.parametrize("scale", [1, 1e-3])
def test_extents_are_those_along_principal_axes(scale):
    rng = np.random.default_rng(0)
    box = np.stack(np.meshgrid(*[np.linspace(-1, 1, 3)] * 3), -1).reshape(-1, 3) * (50, 20, 3)
    shape = _shape(box @ random_rotation(rng) * scale, box * (1, 1, 5))
    np.testing.assert_allclose(shape.extents, np.array([100, 40, 6]) * scale)
    assert shape.is_thin
    assert not shape.is_line


@pytest.mark.parametrize("axis", range(3))
def test_a_mirror_is_reported_first(axis):
    rng = np.random.default_rng(axis)
    half = rng.uniform(-45, 45, (12, 3))
    sign = np.where(np.arange(3) == axis, -1, 1)
    p = np.concatenate([half, half * sign])
    # the names of both sides are mixed up, for another pose and size
    angle = 0.2
    turn = np.roll(np.roll([(np.cos(angle), np.sin(angle), 0), (-np.sin(angle), np.cos(angle), 0),
                            (0, 0, 1)], axis, 0), axis, 1)  # fmt: skip
    q = 1.1 * (p + rng.normal(0, 0.5, p.shape))[np.r_[12:24, 0:12]] @ turn + 7
    affine = np.linalg.lstsq(np.c_[p, np.ones(24)], q, rcond=None)[0][:3]
    assert np.linalg.det(affine) < 0
    value = report(p, q, device=DEVICE)
    assert heading(value)[0].startswith(
        "q is a mirror image of p (left and right are mixed up, or "
    )
    assert f"the axis {'xyz'[axis]} is turned around" in heading(value)[0]
    assert value.smallest_determinant > 0
    shape = _shape(p, q @ random_rotation(np.random.default_rng(5)))
    assert shape.mirror


def test_mirrors_are_claimed_for_mirrors_only():
    for seed in range(300):
        rng = np.random.default_rng(seed)
        count = int(rng.integers(4, 30))
        q = rng.uniform(-80, 80, (count, 3))
        p = smooth_warp(rng)(q) + rng.normal(0, 0.5, q.shape)
        assert not _shape(p, q @ random_rotation(rng)).mirror
        assert _shape(p * (1, -1, 1), q).mirror == "y" or count < 12
        flat = q * (1, 1, 0.01)  # a mirror on a plane is a rotation
        assert not _shape(flat * (-1, 1, 1), flat + rng.normal(0, 0.1, q.shape)).mirror
        assert not _shape(flat * (-1, 1, 1), flat).mirror
    p, q, _, swap = planted_pairs(np.random.default_rng(4))
    assert not _shape(p, q).mirror  # one pair of names is swapped
    value = report(p, q, device=DEVICE)
    assert (value.swapped_with[swap[0]], value.recommended.kind) == (swap[1], "spline")


@pytest.mark.parametrize("moving", [1, 3])
def test_handles_of_a_drag_are_no_outliers(moving, rng):
    p = rng.uniform(-50, 50, (9, 3))
    q = p.copy()
    q[:moving] += (12, 5, 0)
    value = report(p, q, device=DEVICE)
    assert not value.outlier.any()
    assert value.swaps == []
    assert any(
        line.startswith("outliers: not looked for; most pairs rest") for line in heading(value)
    )
    content = json.loads(json.dumps(value.as_dict()))
    assert content["is_drag"]
    assert {"extents", "mirror", "is_sensible"} < {*content}
