"""Landmarks that are moved to the best match of the images around them."""

import numpy as np
import pytest

from vtk_mls import Aborted, Deformation, Grid, HalfPlane
from vtk_mls.landmarks import Image, refine
from vtk_mls.landmarks.text import refinement_heading

sitk = pytest.importorskip("SimpleITK", reason="the extra itk is not installed")
SIZE, SPACING = (44, 40, 36), (1.0, 1.2, 1.5)
MIDDLE = np.array((22.0, 23.0, 26.0))


@pytest.fixture(scope="module")
def texture():
    """A smooth random image of SimpleITK, on an oblique grid."""
    values = np.random.default_rng(4).normal(size=SIZE[::-1])
    image = sitk.SmoothingRecursiveGaussian(sitk.GetImageFromArray(values), 2.0)
    image.SetSpacing(SPACING)
    image.SetOrigin((-3.0, 2.0, 1.0))
    c, s = np.cos(0.2), np.sin(0.2)
    image.SetDirection((c, -s, 0, s, c, 0, 0, 0, 1))
    return image


def _image(image):
    direction = np.reshape(image.GetDirection(), (3, 3))
    grid = Grid(image.GetSize(), image.GetOrigin(), image.GetSpacing(), direction)
    return Image(sitk.GetArrayFromImage(image), grid)


def _resampled(image, transform):
    return sitk.Resample(image, image, transform, sitk.sitkBSpline, 0.0)


def _inner(image, count, rng):
    """Places (n, 3) inside of an image."""
    last = np.array(image.grid.dimensions) - 1
    return image.grid.at(rng.uniform(0.35 * last, 0.65 * last, (count, 3)))


def _moved_by(transform, places):
    return np.array([transform.TransformPoint(place) for place in places.tolist()])


def test_a_shift_is_found_between_the_points(texture, rng):
    shift = sitk.TranslationTransform(3, (1.3, -0.8, 2.15))
    target = _image(_resampled(texture, shift))
    q = _inner(target, 12, rng)
    p = _moved_by(shift, q)
    start = q + rng.uniform(-2, 2, q.shape)
    found = refine(_image(texture), target, p, start)
    assert found.refused == ("",) * 12
    np.testing.assert_allclose(found.deformed, q, rtol=0, atol=0.2)
    np.testing.assert_array_equal(found.match, found.deformed)
    np.testing.assert_allclose(found.moved, np.linalg.norm(found.deformed - start, axis=1))
    assert (found.score > 0.98).all()
    assert (found.score_before < found.score).all()


def test_landmarks_in_a_warped_image(texture, rng):
    warp = sitk.BSplineTransformInitializer(texture, [3, 3, 3])
    warp.SetParameters(rng.normal(0, 1.5, len(warp.GetParameters())).tolist())
    target = _image(_resampled(texture, warp))
    q = _inner(target, 20, rng)
    start = q + rng.uniform(-2, 2, q.shape)
    found = refine(_image(texture), target, _moved_by(warp, q), start)
    is_moved = np.array([not reason for reason in found.refused])
    error = np.linalg.norm(found.deformed - q, axis=1)
    assert is_moved.sum() >= 18
    assert np.median(error[is_moved]) < 0.3
    assert np.median(np.linalg.norm(start - q, axis=1)) > 1.5


def test_a_map_gives_the_window_its_shape(texture, rng):
    turn = sitk.VersorTransform((0, 0, 1), 0.9)
    turn.SetCenter(MIDDLE.tolist())
    target = _image(_resampled(texture, turn))
    q = MIDDLE + rng.uniform(-3, 3, (6, 3))
    p = _moved_by(turn, q)
    corners = MIDDLE + 20 * np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, -1, 0)])
    value = Deformation(_moved_by(turn, corners), corners, "rigid", device="reference")
    start = q + rng.uniform(-1.5, 1.5, q.shape)
    found = refine(_image(texture), target, p, start, deformation=value)
    assert found.refused == ("",) * 6
    np.testing.assert_allclose(found.deformed, q, rtol=0, atol=0.15)
    assert refine(_image(texture), target, p, start).refused.count("") <= 1
    # a cut leaves the part of each window that has material
    cut = HalfPlane(MIDDLE, (1, 0, 0), (0, 0, 1))
    value = Deformation(value.rest, corners, "rigid", cuts=cut, device="reference")
    found = refine(_image(texture), target, p[:1], start[:1], deformation=value)
    assert np.isfinite(found.score).all()


def test_scores_are_those_of_brute_force(texture, rng):
    moving = _image(texture)
    target = Image(
        moving.values + 0.3 * moving.values.std() * rng.normal(size=SIZE[::-1]), moving.grid
    )
    index = np.array((21, 19, 17))
    (q,) = moving.grid.at([index])
    shift = np.array((2, -1, 1))
    (start,) = moving.grid.at([index - shift])
    found = refine(moving, target, [q], [start], radius=5, search=4)
    i, j, k = np.indices(moving.values.shape)[::-1]
    steps = np.rint(5 / np.array(SPACING))
    ball = sum(((a - b) / n) ** 2 for a, b, n in zip((i, j, k), index, steps)) <= 1 + 1e-9
    at = np.argwhere(ball)
    window = moving.values[ball]

    def score(step):
        values = target.values[tuple((at + step[::-1]).T)]
        return np.corrcoef(window, values)[0, 1]

    reach = np.rint(4 / np.array(SPACING)).astype(int)
    axes = [np.arange(-n, n + 1) for n in reach]
    scores = {
        step: score(np.array(step) - shift)
        for step in [(a, b, c) for a in axes[0] for b in axes[1] for c in axes[2]]
    }
    best = max(scores, key=scores.__getitem__)
    assert best == tuple(shift)
    assert found.score_before[0] == pytest.approx(scores[0, 0, 0], abs=1e-9)
    assert scores[best] <= found.score[0] <= scores[best] + 0.05
    assert found.refused == ("",)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda v, q: (v, q + (7, 0, 0)), "at the border of the search"),
        (lambda v, q: (np.roll(v[::-1, ::-1], 5, axis=2), q), "score|other places|border"),
        (lambda v, q: (np.zeros_like(v), q), "target ends or has no contrast"),
        (lambda v, q: (v, q + 1000), "target ends or has no contrast"),
        (lambda v, q: (np.broadcast_to(v[18, 20], v.shape), q), "other places|border"),
    ],
)
def test_an_uncertain_match_moves_nothing(texture, change, reason):
    moving = _image(texture)
    q = moving.grid.at([(21.3, 19.6, 17.2)])
    values, start = change(moving.values, q)
    source = Image(values, moving.grid) if reason.startswith("other") else moving
    found = refine(source, Image(values, moving.grid), q, start)
    np.testing.assert_array_equal(found.deformed, start)
    assert found.moved == [0]
    (sentence,) = found.refused
    assert any(part in sentence for part in reason.split("|"))


def test_a_window_outside_of_the_moving_image(texture):
    moving = _image(texture)
    q = moving.grid.at([(21.3, 19.6, 17.2)])
    found = refine(moving, moving, q + 500, q)
    assert found.refused == ("its window is outside of the moving image",)
    assert np.isnan(found.score).all()
    holes = np.where(np.isfinite(moving.values), np.nan, 0)
    assert refine(Image(holes, moving.grid), moving, q, q).refused == found.refused


def test_a_slice_is_an_image(rng):
    values = sitk.SmoothingRecursiveGaussian(sitk.GetImageFromArray(rng.normal(size=(60, 60))), 2.0)
    array = sitk.GetArrayFromImage(values)
    grid = Grid((60, 60, 1))
    moving, target = Image(array[None], grid), Image(np.roll(array, (2, -3), (0, 1))[None], grid)
    p = np.array([(30.0, 28, 0)])
    found = refine(moving, target, p, p)
    np.testing.assert_allclose(found.deformed, p + (-3, 2, 0), rtol=0, atol=0.1)


def test_images_of_integers_and_a_report_in_words(texture):
    moving = _image(texture)
    scaled = (moving.values - moving.values.min()) / np.ptp(moving.values)
    moving = Image((255 * scaled).astype(np.uint8), moving.grid)
    p = moving.grid.at([(21, 19, 17), (22, 20, 18)])
    found = refine(moving, moving, p, p + [(1, 0, 0), (9, 0, 0)])
    assert found.refused[0] == ""
    assert refinement_heading(found).startswith("1 of 2 landmarks are refined; moved by 0.98")
    np.testing.assert_allclose(found.score[0], 1, atol=1e-3)
    assert found.moved[1] == 0
    assert found.refused[1]
    found = refine(moving, moving, p[1:], p[1:] + (9, 0, 0))
    assert refinement_heading(found).startswith("none of 1 landmarks is refined")


def test_refining_can_be_stopped(texture):
    moving = _image(texture)
    p = moving.grid.at([(21, 19, 17)] * 5)
    done = []

    def note(fraction):
        done.append(fraction)
        return fraction > 0.3

    with pytest.raises(Aborted):
        refine(moving, moving, p, p, progress=note)
    assert done == [0, 0.2, 0.4]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"rest": [(0, 0, 0)] * 2}, "`rest` and `deformed` must have the same number .* 2 and 1"),
        ({"moving": np.ones((3, 3, 3))}, "`moving` must be a landmarks.Image"),
        ({"radius": -1}, "`radius` must be a positive number, got -1"),
        ({"search": 1e5}, "`search` must be at most 40 spacings of the target, 40, got 1e"),
    ],
)
def test_wrong_arguments_are_one_sentence(texture, arguments, sentence):
    image = _image(texture)
    values = {"moving": image, "target": image, "rest": [(0, 0, 0)], "deformed": [(0, 0, 0)]}
    with pytest.raises((ValueError, TypeError), match=sentence):
        refine(**{**values, **arguments})
    with pytest.raises(ValueError, match=r"`values` must be real numbers with the shape of `grid`"):
        Image(np.zeros((2, 2)), image.grid)
