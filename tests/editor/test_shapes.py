"""Rigid regions, curves and the mask in the editor, by mouse and keys."""

from __future__ import annotations

import argparse

import numpy as np
import pytest
from hands import MIDDLE, SIZE, Hands, ball_mesh, bone
from vtk_fixtures import scalar_image

from vtk_mls import Ball, BallMask, Capsule, CurveHandle, Grid, Labels, RegionHandle, Solid, io
from vtk_mls.commands import view
from vtk_mls.editor import State
from vtk_mls.editor.handle_glyphs import DRAWN
from vtk_mls.editor.handle_polydata import handle_polydata
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.shape_surfaces import surface_of

CENTERS = np.array([(7, 11, 11), (17, 11, 11)])
FIRST = 27  # row of the first grip after the lattice
IN_BONE = 26  # likewise, if the middle of the lattice is in a region


def turn(axis, angle, shift=(0, 0, 0)):
    """A motion: rotation about an axis of the world, then a shift."""
    motion, (i, j) = np.eye(4), [k for k in range(3) if k != axis]
    motion[i, i] = motion[j, j] = np.cos(angle)
    motion[i, j], motion[j, i] = -np.sin(angle), np.sin(angle)
    motion[:3, 3] = shift
    return motion


def segments():
    """Two balls of the label 3, which do not touch."""
    geometry = ImageGeometry((0, SIZE - 1) * 3)
    distance = np.linalg.norm(geometry.grid.indices()[:, None] - CENTERS, axis=2).min(axis=1)
    return scalar_image(3 * (distance < 3).astype(np.uint8), geometry, "seg")


@pytest.fixture
def rigid_bone():
    """A ball with a bone that is made rigid."""
    hands = Hands([ball_mesh(), bone()])
    hands.move(hands.pixels(np.full((1, 3), MIDDLE))[0, :2])
    hands.press("g")
    return hands


def test_g_makes_a_mesh_in_the_data_rigid_and_the_mouse_moves_it(rigid_bone):
    hands = rigid_bone
    (region,) = hands.state.handles
    assert isinstance(region.shape, Solid)
    np.testing.assert_allclose(region.shape.bounds.mean(axis=0), MIDDLE, atol=1e-5)
    np.testing.assert_array_equal(region.motion, np.eye(4))
    assert hands.editor.selected.tolist() == [IN_BONE]
    assert "1 rigid" in hands.editor.status
    assert "removed handles in it: 1." in hands.message
    start, before = hands.pixel_of(IN_BONE), hands.picture()
    hands.drag(start, (18, 12))
    np.testing.assert_allclose(hands.pixel_of(IN_BONE), start + (18, 12), atol=1.5)
    motion = hands.state.handles[0].motion
    np.testing.assert_array_equal(motion[:3, :3], np.eye(3))
    assert np.abs(hands.picture() - before).mean() > 0.3
    # the data follow: inside the bone by its motion, also as drawn
    inside = region.shape.bounds.mean(axis=0) + [(0.5, 2, -0.3)]
    moved = hands.state.deformation().forward(inside)
    np.testing.assert_allclose(moved - inside, motion[None, :3, 3], atol=1e-4)
    drawn = hands.editor.scene.items[1].mesh()
    np.testing.assert_allclose(
        np.mean(np.reshape(drawn.GetBounds(), (3, 2)), axis=1), MIDDLE + motion[:3, 3], atol=1e-3
    )
    hands.press("z")
    np.testing.assert_array_equal(hands.state.handles[0].motion, np.eye(4))
    hands.press("x")
    assert hands.state.handles == ()
    assert len(hands.state) == 26
    hands.press("z")
    hands.press("l")
    inside = region.shape.distance(hands.state.rest)[0] == 0
    assert len(hands.state) > 40
    assert not inside.any()


def test_the_box_turns_a_region_about_its_center(rigid_bone):
    hands = rigid_bone
    camera = hands.camera
    hands.drag(hands.pixel_of(IN_BONE) + (9, 9), (25, 5))
    motion = hands.state.handles[0].motion
    angle = np.arccos(np.clip((np.trace(motion[:3, :3]) - 1) / 2, -1, 1))
    assert angle > 0.1
    np.testing.assert_allclose(motion[:3, :3] @ motion[:3, :3].T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(hands.state.grips.deformed[IN_BONE], MIDDLE, atol=1e-5)
    assert hands.camera == camera
    hands.press("z")
    np.testing.assert_array_equal(hands.state.handles[0].motion, np.eye(4))
    hands.press("y")
    np.testing.assert_array_equal(hands.state.handles[0].motion, motion)
    hands.press("0")
    np.testing.assert_array_equal(hands.state.handles[0].motion, np.eye(4))
    # without a selection there is no box
    hands.press("Escape")
    hands.drag(hands.pixel_of(IN_BONE) + (9, 9), (25, 5))
    np.testing.assert_array_equal(hands.state.handles[0].motion, np.eye(4))
    assert hands.camera != camera


def test_g_makes_one_connected_segment_rigid():
    hands = Hands(segments())
    hands.move(hands.pixels(CENTERS[:1].astype(float))[0, :2])
    hands.press("g")
    (region,) = hands.state.handles
    index = np.argwhere(region.shape.mask)[:, ::-1]
    assert np.linalg.norm(index - CENTERS[0], axis=1).max() < 3
    values = arrays.to_numpy(segments().GetPointData().GetScalars())
    assert 2 * len(index) == (values > 0).sum()
    hands.press("g")
    assert len(hands.state.handles) == 1
    assert "rigid already" in hands.message
    hands.move((3, 3))
    hands.press("g")
    assert "no segment" in hands.message


def test_an_open_mesh_is_refused():
    hands = Hands([ball_mesh(), bone(is_closed=False)])
    hands.move(hands.pixels(np.full((1, 3), MIDDLE))[0, :2])
    hands.press("g")
    assert "must be a closed surface" in hands.message
    assert hands.state.handles == ()


def test_u_makes_a_handle_a_ball_that_turns():
    hands = Hands(ball_mesh())
    row = int(hands.pixels(hands.state.deformed)[:, 2].argmin())
    hands.drag(hands.pixel_of(row), (10, 6))
    before = hands.state
    hands.press("u")
    state = hands.state
    (region,) = state.handles
    assert isinstance(region.shape, Ball)
    assert len(state) == 26
    np.testing.assert_array_equal(region.shape.center, before.rest[row])
    np.testing.assert_allclose(state.grips.deformed[26], before.deformed[row], atol=1e-12)
    assert hands.editor.document.selected_region == 0
    hands.press("u")
    assert "Only a point handle" in hands.message
    hands.press("z")
    assert len(hands.state) == 27
    assert hands.state.handles == ()


def test_w_limits_the_deformation_to_a_ball_that_the_mouse_sizes():
    hands = Hands(ball_mesh())
    row = int(hands.pixels(hands.state.deformed)[:, 2].argmin())
    hands.drag(hands.pixel_of(row), (10, 6))
    hands.press("w")
    mask = hands.state.mask
    np.testing.assert_allclose(mask.center, hands.state.deformed[row])
    far = mask.center + [(mask.radius + mask.falloff) * np.array((0.6, 0.8, 0))]
    np.testing.assert_array_equal(hands.state.deformation().backward(far), far)
    assert "mask" in hands.editor.status
    low, high, outer = FIRST, FIRST + 1, FIRST + 2
    hands.drag(hands.pixel_of(outer), (0, 12))
    wider = hands.state.mask
    assert wider.falloff > mask.falloff
    assert wider.radius == mask.radius
    hands.drag(hands.pixel_of(high), (0, -8))
    smaller = hands.state.mask
    assert smaller.radius < wider.radius
    assert smaller.falloff == wider.falloff
    hands.drag(hands.pixel_of(low), (-12, 0))
    assert hands.state.mask.radius == pytest.approx(smaller.radius)
    assert np.linalg.norm(hands.state.mask.center - smaller.center) > 0.3
    hands.press("w")
    assert hands.state.mask is None
    hands.press("z")
    assert hands.state.mask is not None
    hands.editor.select([FIRST])
    hands.press("Delete")
    assert hands.state.mask is None


def test_d_draws_a_curve_whose_nodes_are_dragged():
    hands = Hands(ball_mesh())
    hands.editor.select(range(1, 27))
    hands.press("x")
    pixels = np.array([(80, 110), (110, 125), (140, 125), (160, 110)])
    nodes = [hands.hit(at) for at in pixels]
    hands.press("d")
    for at in pixels:
        hands.click(at)
    hands.press("Return")
    (curve,) = hands.state.handles
    np.testing.assert_allclose(curve.deformed, nodes, atol=1e-3)
    np.testing.assert_array_equal(curve.rest, curve.deformed)
    assert len(hands.editor.selected) == 4
    hands.press("Escape")
    row = int(hands.state.grips.rows_of(0)[2])
    hands.drag(hands.pixel_of(row), (0, 20))
    moved = hands.state.handles[0]
    changed = (moved.deformed != curve.deformed).any(axis=1)
    assert changed.tolist() == [False, False, True, False]
    np.testing.assert_array_equal(moved.rest, curve.rest)
    hands.press("x")
    assert len(hands.state.handles[0].rest) == 3
    for _ in range(2):
        hands.editor.select(hands.state.grips.rows_of(0)[:1])
        hands.press("x")
    assert hands.state.handles == ()
    hands.press("d")
    hands.click(pixels[0])
    hands.press("d")
    assert "at least two nodes" in hands.message


def test_a_curve_is_drawn_in_a_slice():
    hands = Hands(ball_mesh(), pixels=400)
    hands.press("m")
    hands.tick()
    pane = hands.editor.slices.pane_at((340, 340))
    pixels = (330, 340), (350, 330), (360, 350)

    def are_drawn():
        """Whether the picture has the color of a curve that is drawn at each of the pixels."""
        picture = hands.picture()
        return [bool(np.abs(picture[y, x] - DRAWN).max() < 70) for x, y in pixels]

    hands.press("d")
    for number, at in enumerate(pixels, 1):
        hands.click(at)
        assert are_drawn() == [True] * number + [False] * (3 - number)
    hands.press("Escape")
    assert are_drawn() == [False] * 3
    hands.press("d")
    for at in pixels:
        hands.click(at)
    hands.press("Return")
    assert are_drawn() == [False] * 3
    (curve,) = hands.state.handles
    assert len(curve.rest) == 3
    np.testing.assert_allclose(curve.rest[:, pane.axis], hands.editor.slices.point[pane.axis])


def _is_line_of(curve):
    """Whether the deformed nodes are on a line, in order, at the distances of the rest nodes."""
    steps = np.diff(curve.deformed, axis=0)
    lengths = np.linalg.norm(np.diff(curve.rest, axis=0), axis=1)
    expected = np.outer(lengths / lengths.sum(), steps.sum(axis=0))
    return (
        np.abs(steps - expected).max() < 1e-6 * lengths.sum()
        and np.abs(np.linalg.norm(steps, axis=1) - lengths).max() < 1e-6 * lengths.sum()
    )


def _s_shape(z=0.0):
    """Nodes of a curve in a plane z."""
    x = np.linspace(0, SIZE, 9)
    return np.c_[x, MIDDLE + 0.15 * SIZE * np.sin(2 * np.pi * x / SIZE), np.full(9, z)]


def test_9_straightens_the_only_curve_and_its_surroundings_do_not_turn_over(rng):
    rest = _s_shape(MIDDLE)
    hands = Hands(ball_mesh(), State([], [], handles=[CurveHandle(rest, rest)]))
    hands.press("9")
    (curve,) = hands.state.handles
    assert _is_line_of(curve)
    np.testing.assert_array_equal(curve.rest, rest)
    ends = curve.deformed[[0, -1]]
    np.testing.assert_allclose(ends.mean(axis=0), rest[[0, -1]].mean(axis=0), atol=1e-9)
    np.testing.assert_allclose(ends[:, 1:], MIDDLE, atol=1e-9)
    assert ends[0, 0] < ends[1, 0]
    # a tube of a tenth of the length; its direction across the plane of the curve stays
    near = ends[0] + rng.uniform(0, 1, (500, 1)) * (ends[1] - ends[0])
    near += rng.uniform(-0.05, 0.05, near.shape) * SIZE

    def is_upright(state):
        jacobian = state.deformation().jacobian(near)
        assert (np.linalg.det(jacobian) > 0).all()
        return (jacobian[:, 2, 2] > 0).all()

    assert is_upright(hands.state)
    rows = np.arange(1, 8, 2)
    offset = hands.state.moved(rows, curve.deformed[rows] + (0, 0.005 * SIZE, 0))
    assert not is_upright(offset)  # nodes off the line, by less than a pixel
    hands.press("z")
    np.testing.assert_array_equal(hands.state.handles[0].deformed, rest)


def test_9_straightens_selected_curves_where_they_are_moved():
    tilted = _s_shape() @ turn(2, 0.5)[:3, :3].T
    ring = MIDDLE + 5 * np.array([(0, 0, 2), (1, 0, 0), (0, 0, -2), (-1, 0, 0), (0, 0, 2)])
    curves = [CurveHandle(_s_shape(), tilted), CurveHandle(ring, ring)]
    hands = Hands(ball_mesh(), State([], [], handles=curves))
    hands.press("9")
    assert "Select a node" in hands.message
    hands.editor.select([3])
    hands.press("9")
    first, second = hands.state.handles
    assert second is curves[1]
    assert _is_line_of(first)
    chord, line = (x[-1] - x[0] for x in (tilted, first.deformed))
    np.testing.assert_allclose(np.cross(chord, line), 0, atol=1e-6)
    assert chord @ line > 0
    hands.editor.select(hands.state.grips.rows_of(1)[:2])
    hands.press("9")
    closed = hands.state.handles[1]  # has only a principal direction
    assert _is_line_of(closed)
    np.testing.assert_allclose(closed.deformed[:, :2], MIDDLE, atol=1e-6)
    np.testing.assert_allclose(closed.deformed[[0, -1], 2].mean(), ring[0, 2])
    hands.press("z")
    hands.editor.select_all()
    hands.press("9")
    assert all(map(_is_line_of, hands.state.handles))


def test_9_ends_a_curve_that_is_drawn_and_needs_one():
    hands = Hands(ball_mesh())
    before = hands.state
    hands.press("9")
    assert hands.message == "There is no curve to straighten: press D to draw one."
    assert hands.state is before
    hands.press("d")
    for at in ((80, 110), (120, 130), (160, 110)):
        hands.click(at)
    hands.press("9")
    assert _is_line_of(hands.state.handles[0])
    assert hands.message.startswith("Straightened")


@pytest.mark.parametrize("key", ["d", "p", "a"])
def test_a_click_beside_the_surface_says_so(key):
    hands = Hands(ball_mesh(), State([(0, 0, 0)], [(0, 0, 0)]))
    hands.move((3, 3))
    hands.press(key)
    if key != "a":
        hands.click((3, 3))
    assert hands.message.startswith("There is no surface at this place")
    assert hands.editor.status.startswith("1 handle ")


def shapes():
    """A state with each shape, moved."""
    mask = np.zeros((5, 6, 7), bool)
    mask[1:4, 2:5, 1:5] = True
    triangles = surface_of(Ball((4, 4, 4), 2))
    moves = [turn(axis, 0.4 + axis, (1, -axis, 0.5)) for axis in (0, 1, 2, 0)]
    solids = (
        Ball((1, 2, 3), 0.5),
        Capsule((3, 3, 3), (9, 3, 3), 1),
        Solid(*triangles),
        Labels(mask, Grid((7, 6, 5), (10, 11, 12), (0.5, -0.7, 0.9))),
    )
    curve = CurveHandle([(0, 0, 0), (1, 0, 0), (2, 1, 0)], [(0, 0, 1), (1, 0, 2), (2, 1, 3)])
    rest = np.array([(0.0, 0, 0), (5, 0, 1)])
    return State(
        rest,
        rest + 1,
        labels=("tip", ""),
        handles=[*map(RegionHandle, solids, moves), curve],
        mask=BallMask((5, 5, 5), 20, 3),
    )


def test_grips_of_all_shapes_move_their_handles_only():
    state = shapes()
    grips = state.grips
    assert len(grips) == 2 + 4 + 3 + 3
    for row in range(len(grips)):
        target = grips.deformed[row] + (0.3, 0.2, 0.6)
        after = state.moved([row], [target])
        others = np.setdiff1d(np.flatnonzero(grips.owner != -2), [row])
        np.testing.assert_allclose(after.grips.deformed[others], grips.deformed[others])
        if grips.owner[row] != -2:
            np.testing.assert_allclose(after.grips.deformed[row], target)
            assert after.mask is state.mask
    everything = state.moved(range(len(grips)), grips.deformed + (1, 0, 0))
    np.testing.assert_allclose(everything.grips.deformed, grips.deformed + (1, 0, 0))


def test_half_of_the_movement_is_that_of_each_handle():
    state = shapes().changed(blend=0.5)
    half = state.deformation().handles
    twice = half[2].motion @ half[2].motion
    np.testing.assert_allclose(twice, state.handles[2].motion, atol=1e-12)
    np.testing.assert_allclose(half[4].deformed[:, 2], (0.5, 1, 1.5))
    assert state.at_rest().is_identity
    assert state.at_rest().deformation() is None


def test_saved_handles_are_opened_again(tmp_path):
    state = shapes().changed(weights=np.array([1.0, 2.5]))
    io.write_dataset(handle_polydata(state), tmp_path / "handles.vtp")
    parser = argparse.ArgumentParser()
    view.add(parser)
    mask = "--mask-ball=5,5,5,20,3"
    files = "ball.vtp", str(tmp_path / "handles.vtp")
    opened = view._state(parser.parse_args([*files, "--handle-shapes", "cells", mask]))
    for name in ("rest", "deformed", "weights"):
        np.testing.assert_array_equal(getattr(opened, name), getattr(state, name))
    assert opened.labels == state.labels
    np.testing.assert_array_equal(opened.mask.center, (5, 5, 5))
    assert (opened.mask.radius, opened.mask.falloff) == (20, 3)
    curve, *regions = opened.handles
    np.testing.assert_array_equal(curve.rest, state.handles[-1].rest)
    np.testing.assert_array_equal(curve.deformed, state.handles[-1].deformed)
    for region, saved in zip(regions, state.handles[:-1], strict=True):
        np.testing.assert_allclose(region.motion, saved.motion, atol=1e-9)
        low, high = saved.shape.bounds
        size = (high - low).max()
        points = np.random.default_rng(3).uniform(low - size / 3, high + size / 3, (200, 3))
        expected, distances = (r.shape.distance(points)[0] for r in (saved, region))
        np.testing.assert_allclose(distances, expected, atol=0.07 * size)


def test_slices_outline_a_region_where_it_is_moved():
    region = RegionHandle(Ball((MIDDLE,) * 3, 3), turn(2, 0.3, (0, 0, 0)))
    hands = Hands(ball_mesh(), State([(0, 0, 0)], [(0, 0, 0)], handles=[region]), pixels=400)
    hands.press("m")
    hands.tick()
    pane = hands.editor.slices._panes[0]
    corners = np.array(
        [pane._outlines.GetPoint(i) for i in range(pane._outlines.GetNumberOfPoints())]
    )
    distances = np.linalg.norm(corners[:, :2] - region.center[1][:2], axis=1)
    assert (np.abs(distances - 3) < 0.1).sum() > 20
