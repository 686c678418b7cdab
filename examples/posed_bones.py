"""A frog leaps: rigid bones
=========================

Each bone of the hind legs is a rigid region: a label of the segmentation, and a motion. Bones keep
their shape, and what is between them follows. A pose this large is made in steps, because
small deformations rarely fold.

You will see the frog at rest, posed by its bones, and posed by control points at the ends of the
same bones, which bends them. The end checks places and volumes of the bones.

The frog is the segmentation that PyVista's package carries. It has no skin; the
one that is drawn lies around all of its tissues.
"""

import itertools

import numpy as np
import pyvista as pv

from vtk_mls import Capsule, Deformation, Grid, Labels, RegionHandle

SKELETON, STEPS = 13, 6

frog = pv.examples.load_frog_tissues().extract_subset((0, 499, 0, 469, 0, 135), rate=(3, 3, 2))
frog = frog.pad_image(pad_size=15, dimensionality="preserve")
frog["bone"] = (frog.active_scalars == SKELETON).astype(np.float32)
frog["body"] = (frog.active_scalars > 0).astype(np.float32)
grid = Grid(frog.dimensions, frog.points[0], frog.spacing)

# Both ends of femur, shank, ankle and foot; x to the head, y to the right, z to the belly.
LEFT = [(124, 208, 162), (194, 60, 157), (168, 46, 165), (64, 184, 147)]
LEFT += [(47, 182, 147), (42, 97, 176), (58, 92, 176), (135, 30, 188)]
RIGHT = [(124, 253, 162), (194, 412, 155), (163, 423, 164), (73, 281, 122)]
RIGHT += [(56, 287, 129), (37, 360, 162), (42, 370, 166), (150, 450, 188)]
ENDS = np.array([LEFT, RIGHT], float).reshape(8, 2, 3)
DEGREES = (65, -80, 55, 40)  # about the end of the bone before: hip, knee, heel, toes
RADII = (18, 18, 18, 55)


def pose(share):
    """Motions (8, 4, 4) of the bones, after a `share` of the leap."""
    motions = []
    for bones, side in ((ENDS[:4], -1), (ENDS[4:], 1)):
        motion, joint = np.eye(4), bones[0, 0]
        for (_, end), degrees in zip(bones, DEGREES):
            motion = motion @ pv.Transform().rotate_z(side * share * degrees, point=joint).matrix
            motions.append(motion)
            joint = end
    return np.array(motions)


def moved(motion, points):
    return points @ motion[:3, :3].T + motion[:3, 3]


# A voxel of a leg is part of the bone whose axis is the nearest. Joints are part of none.
points = grid.points()
distances = np.array([Capsule(*ends, 1).distance(points)[0] for ends in ENDS])
nearest, (first, second) = distances.argmin(axis=0), np.sort(distances, axis=0)[:2]
radius = np.tile(RADII, 2)[nearest]
lost = (nearest == 7) & (points[:, 0] > 90)  # toes that lie on the knee
near_bone = frog.gaussian_smooth(std_dev=0.8, scalars="bone")["bone"] > 0.15
is_leg = near_bone & (first < radius) & (second > first + 5) & ~lost
pelvis = near_bone & (first > radius + 9) & (points[:, 0] < 205) & (abs(points[:, 1] - 229) < 40)
masks = [(is_leg & (nearest == i)).reshape(grid.shape) for i in range(8)]
still = [Capsule((230, 229, 40), (460, 229, 35), 75), Labels(pelvis.reshape(grid.shape), grid)]
still += [
    Capsule((270, 80, 110), (300, 80, 175), 25),
    Capsule((270, 380, 110), (300, 370, 175), 30),
]
trunk = [RegionHandle(shape, np.eye(4)) for shape in still]


def as_regions(start, stop):
    """The step between two poses, by regions."""
    handles = list(trunk)
    for mask, a, b in zip(masks, start, stop):
        here = Grid(grid.dimensions, moved(a, grid.origin), grid.spacing, a[:3, :3])
        handles.append(RegionHandle(Labels(mask, here), b @ np.linalg.inv(a)))
    return Deformation(handles=handles)


def as_points(start, stop):
    """The step between two poses, by the ends of the bones."""
    rest, deformed = (
        np.vstack([moved(m, ends) for m, ends in zip(p, ENDS)]) for p in (start, stop)
    )
    return Deformation(rest, deformed, handles=trunk)


poses = [pose(share) for share in np.linspace(0, 1, STEPS + 1)]
steps = {way: [way(a, b) for a, b in itertools.pairwise(poses)] for way in (as_regions, as_points)}


def posed(mesh, way):
    mesh = mesh.copy()
    for step in steps[way]:
        mesh.points = step.forward(mesh.points)
    return mesh


def surface(values, level, std_dev):
    """The surface of a volume where its blurred `values` (n,) pass a level."""
    volume = pv.ImageData(dimensions=frog.dimensions, spacing=frog.spacing, origin=grid.origin)
    volume["values"] = values.astype(np.float32)
    return (
        volume.gaussian_smooth(std_dev=std_dev)
        .contour([level])
        .smooth_taubin(n_iter=30, pass_band=0.1)
    )


solid = (frog["bone"] > 0) & ~lost
inner = solid & is_leg & (second > first + 9)
bones = [surface(inner & (nearest == i), 0.4, 0.8) for i in range(8)]
others = surface(solid & (first > radius + 6), 0.4, 0.8)
skin = surface((frog["body"] > 0) & ~lost, 0.06, 2.6).connectivity("largest")

ways = {"at rest": None, "rigid bones": as_regions, "points at their ends": as_points}
drawn = {}
plotter = pv.Plotter(shape=(1, 3), border=False, window_size=(1500, 736))
for column, (title, way) in enumerate(ways.items()):
    drawn[title] = [posed(mesh, way) if way else mesh for mesh in (skin, others, *bones)]
    plotter.subplot(0, column)
    plotter.set_background("#12161f")
    for mesh in drawn[title][1:]:
        plotter.add_mesh(mesh.compute_normals(), color="#f2e8cc", smooth_shading=True, specular=0.3)
    look = {"opacity": 0.35, "smooth_shading": True, "specular": 0.6, "specular_power": 30}
    plotter.add_mesh(drawn[title][0].compute_normals(), color="#7fb069", **look)
    plotter.add_text(title, font_size=15, color="white", position="upper_edge")
    plotter.camera_position = [(117, 232, -1500), (117, 232, 90), (1, 0, 0)]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 412
plotter.screenshot("posed_bones.png")

# Bones move as their motions say, and keep their size.
off = []
for i, motion in enumerate(poses[-1]):
    voxels = pv.PolyData(points[inner & (nearest == i)])
    error = posed(voxels, as_regions).points - moved(motion, voxels.points)
    off.append(np.abs(error).max() / frog.length)
print(f"Voxels of bones are where the motions take them, to {max(off):.1e} of the frog")
assert max(off) < 1e-5
for title, limit in (("rigid bones", 1e-4), ("points at their ends", np.inf)):
    volumes = np.array([(mesh.volume, bone.volume) for mesh, bone in zip(drawn[title][2:], bones)])
    change = np.abs(volumes[:, 0] / volumes[:, 1] - 1).max()
    print(f"{title}: volumes of bones change by up to {change:.1e}")
    assert change < limit
