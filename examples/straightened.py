"""A vessel, straightened
=======================

A curve handle carries every point of a polyline. Where its deformed nodes lie on a line, it
straightens the volume along the curve: the centerline of a vessel, a spine, a fish.

You will see a vessel and its centerline in a CT, the slice through their middle, which cuts the
vessel in pieces, and the same of the straightened CT: one slice has all of the vessel, with an
aneurysm and a stenosis. The end checks lengths and the line.

The CT is synthetic: a vessel with plaques, in front of vertebrae.
"""

import numpy as np
import pyvista as pv

from vtk_mls import CurveHandle, Deformation, Grid, Sampling


def straight(centerline):
    """The handle that straightens a curve to a line of the same length.

    Parameters
    ----------
    centerline : (m, 3) array_like, world coordinates
        Its nodes, in order.

    Returns
    -------
    CurveHandle
        To a line about the middle of the curve, along the direction from its first to its last
        node. Nodes keep their distance along the curve.

    Raises
    ------
    ValueError
        If the curve runs back: a line does not tell how far its surroundings are turned about it,
        and they turn over where a curve does.
    """
    nodes = np.asarray(centerline, float)
    steps = np.diff(nodes, axis=0)
    direction = (nodes[-1] - nodes[0]) / np.linalg.norm(nodes[-1] - nodes[0])
    if (steps @ direction <= 0).any():
        row = int(np.argmax(steps @ direction <= 0))
        raise ValueError(
            "`centerline` must not run back against the direction from its first to its last node, "
            f"got a step that does after node {row}; straighten its parts one by one"
        )
    lengths = np.linalg.norm(steps, axis=1)
    along = np.concatenate([[0], np.cumsum(lengths)]) - lengths.sum() / 2
    return CurveHandle(nodes, nodes.mean(axis=0) + np.outer(along, direction))


def grid_along(handle, radius, spacing):
    """A grid around the line of a handle: its third axis is the line.

    Parameters
    ----------
    handle : CurveHandle
        As `straight` returns it.
    radius : float, world units
        Half the width of the grid, across the line.
    spacing : float, world units
    """
    line = handle.deformed[-1] - handle.deformed[0]
    length = np.linalg.norm(line)
    first = np.cross(np.eye(3)[np.abs(line).argmin()], line / length)
    first /= np.linalg.norm(first)
    axes = np.column_stack([first, np.cross(line / length, first), line / length])
    width = round(2 * radius / spacing) + 1
    origin = handle.deformed[0] - axes[:, :2] @ [radius, radius]
    return Grid((width, width, int(length / spacing) + 1), origin, [spacing] * 3, axes)


# A curve that no plane follows, and distances of voxels from it.
z = np.linspace(0, 180, 721)
curve = np.column_stack(
    [50 + 22 * np.sin(2 * np.pi * z / 140), 46 + 14 * np.sin(2 * np.pi * z / 100 + 2), z]
)
grid = Grid((101, 101, 181))
points = grid.points()
rows = np.rint(4 * points[:, 2]).astype(int)
near = np.flatnonzero(np.linalg.norm(points - curve[rows], axis=1) < 25)
distance, place = np.full(len(points), 99.0), np.zeros(len(points))
for part in np.array_split(near, 40):
    squares = ((points[part, None] - curve[None, ::2]) ** 2).sum(axis=2)
    distance[part], place[part] = np.sqrt(squares.min(axis=1)), z[::2][squares.argmin(axis=1)]


def bump(center, width):
    return np.exp(-(((place - center) / width) ** 2))


# Hounsfield units: soft tissue with fat, vertebrae, a vessel with contrast, its wall and plaques.
rng = np.random.default_rng(5)
ct = pv.ImageData(dimensions=grid.dimensions)
ct["HU"] = rng.normal(size=len(points))
fat = ct.gaussian_smooth(std_dev=3)["HU"]
noise = ct.gaussian_smooth(std_dev=0.7)["HU"]
hu = 45 - 110 / (1 + np.exp(8 - 8 * fat / fat.std()))
vertebra = np.hypot((points[:, 0] - 50) / 19, (points[:, 1] - 88) / 14) < 1
hu[vertebra] = np.where(points[vertebra, 2] % 34 < 27, 330, 90)
lumen = 5 - 3.2 * bump(62, 6) + 4.5 * bump(128, 11)
hu[distance < lumen + 1.5] = 110
plaque = (distance > lumen) & (distance < 6) & (np.abs(place - 62) < 9) & (np.abs(place - 62) > 2)
hu[plaque & (points[:, 0] > curve[rows, 0])] = 800
hu[distance < lumen] = 400
ct["HU"] = (hu + 60 * noise).astype(np.float32)
ct = ct.gaussian_smooth(std_dev=0.6)

handle = straight(curve[::8])
target = grid_along(handle, radius=18, spacing=0.5)
d = Deformation(handles=[handle])
sampling = Sampling(source=grid, target=target, background=-1000)
(values,) = d.resample([ct["HU"].reshape(grid.shape)], sampling)
straightened = pv.ImageData(dimensions=target.dimensions, spacing=target.spacing)  # in its own axes
straightened["HU"] = values.ravel()

plotter = pv.Plotter(shape=(1, 4), border=False, window_size=(1320, 760))
gray = {"scalars": "HU", "cmap": "gray", "clim": (-150, 550), "show_scalar_bar": False}
in_front_of_bone = ct.extract_subset((0, 100, 0, 73, 0, 180))
nodes = target.index_of(handle.deformed) * target.spacing  # in those axes
shown = ((ct, in_front_of_bone, handle.rest), (straightened, straightened, nodes))
for column, title in enumerate(("a vessel in a CT", "a slice", "straightened", "a slice of it")):
    volume, part, curve_nodes = shown[column // 2]
    middle = np.array(volume.center)
    plotter.subplot(0, column)
    plotter.set_background("#12161f")
    if column in (1, 3):
        plane = volume.slice("y", origin=curve_nodes.mean(axis=0))
    else:
        plane = volume.slice("y", origin=middle + (0, middle[1] - 1, 0))
        vessel = part.contour([260], scalars="HU").connectivity("largest").smooth_taubin(n_iter=40)
        look = {"color": "#d0413a", "opacity": 0.6, "smooth_shading": True, "specular": 0.4}
        plotter.add_mesh(vessel, **look)
        tube = pv.MultipleLines(curve_nodes).tube(radius=0.8)
        plotter.add_mesh(tube, color="orange", lighting=False)
    plotter.add_mesh(plane, lighting=False, **gray)
    plotter.add_text(title, font_size=14, color="white", position="upper_edge")
    plotter.camera_position = [middle - (0, 500, 0), middle, (0, 0, 1)]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 138
plotter.screenshot("straightened.png")

# Points of the curve lie on the line, as far along it as along the curve.
share = np.linspace(0, 1, 1000)
lengths = np.linalg.norm(np.diff(handle.rest, axis=0), axis=1)
reached = np.concatenate([[0], np.cumsum(lengths)]) / lengths.sum()
on_curve = np.column_stack([np.interp(share, reached, c) for c in handle.rest.T])
line = handle.deformed[0] + np.outer(share, handle.deformed[-1] - handle.deformed[0])
error = np.abs(d.forward(on_curve) - line).max() / lengths.sum()
determinant = np.linalg.det(d.jacobian_field(target))
print(f"{lengths.sum():.0f} mm of the curve are on the line, to {error:.1e} of its length")
assert error < 1e-4
print(f"Nothing folds: determinants are {determinant.min():.2f} to {determinant.max():.2f}")
assert determinant.min() > 0
