"""Regions, curves and limits in the layout of the kernels, in the frame of control points."""

import numpy as np

from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, STRUCTS, transform


class Images:
    """Values of images, one after the other, in the buffer that kernels read."""

    def __init__(self):
        self._values, self._count, self._first = [], 0, {}

    def add_once(self, image):
        """Add the distances of a DistanceImage and its border; the positions of their first."""
        if image not in self._first:
            self._first[image] = self.add(image.values / image.step), self.add(image.border)
        return self._first[image]

    def add(self, values):
        """Add an array; the position of its first value."""
        first = self._count
        self._values.append(np.asarray(values, np.float32).ravel())
        self._count += self._values[-1].size
        return first

    def table(self):
        """All values, (m,) float32."""
        return np.concatenate([np.zeros(0, np.float32), *self._values])


def region_table(control_points, in_rest_frame, images):
    """The regions: (n,) region_t. Their distances are added to `images`."""
    handles, scale = control_points.handles, control_points.scale
    table = np.zeros(len(handles.regions), STRUCTS["region_t"])
    if not handles.regions:
        return table
    anchors = control_points.local(handles.term_anchors[0 if in_rest_frame else 1])
    for i, (row, region) in enumerate(zip(table, handles.regions)):
        row["anchor"] = anchors[i]
        proxies = np.flatnonzero(handles.region == i)
        row["first_proxy"], row["proxy_count"] = proxies[0], len(proxies)
        p, q = (handles.centered(x, proxies) / scale for x in (handles.rest, handles.deformed))
        share = handles.weights[proxies] / handles.weights[proxies].sum()
        row["moments"] = np.einsum("i,ia,ib->ab", share, p, q).ravel()
        row["spread"] = np.einsum("i,ia,ia->", share, q, q)
        turn, offset = region.to_shape
        image = region.shape.image
        if image is None:
            a, b = ((x - offset) @ turn for x in (region.shape.a, region.shape.b))
            row["end"], row["along"] = control_points.local(a), (b - a) / scale
            row["radius"] = region.shape.radius / scale
        else:
            row["step"] = image.step / scale
            to_index = image.grid.world_to_index @ turn
            moved = image.grid.index_of((turn @ control_points.center + offset)[None])[0]
            row["to_index"] = transform(scale * to_index, moved)
            row["size"] = image.grid.dimensions
            row["last"] = row["size"] - 1
            row["first"], row["border"] = images.add_once(image)
            row["face"], row["row"] = image.border[0].size, image.border[0, 0].size
    return table


def segment_table(control_points):
    """The segments of curves: (s,) segment_t."""
    segments, scale = control_points.handles.segments, control_points.scale
    table = np.zeros(len(segments), STRUCTS["segment_t"])
    if len(segments) == 0:
        return table
    u = (segments.rest - segments.deformed - control_points.mean_displacement) / scale
    for name, ends in (("q", control_points.local(segments.deformed)), ("u", u)):
        table[name], table[f"along_{name}"] = ends[:, 0], ends[:, 1] - ends[:, 0]
    table["c"] = segments.weights / kernel_arguments.mean_weight(control_points)
    length2 = (table["along_q"].astype(float) ** 2).sum(axis=1)
    table["length2"], table["density"] = length2, 1 / length2
    return table


def limit_table(limits, control_points, images):
    """The masks and faces: (n,) limit_t. Their values are added to `images`."""
    table = np.zeros(len(limits), STRUCTS["limit_t"])
    for row, limit in zip(table, limits):
        record = limit.record(control_points)
        values, grid = record.pop("image", None), record.pop("grid", None)
        record["form"] = CONSTANTS[record["form"]]
        if values is not None:
            row["first"] = images.add(values)
            row["size"] = grid.dimensions
            center = grid.index_of(control_points.center[None])[0]
            row["to_index"] = transform(control_points.scale * grid.world_to_index, center)
        for name, value in record.items():
            row[name] = value
    return table


def map_tables(deformation, control_points):
    """The tables of all steps as `map_of` in weights.cl reads them, (m,) float32.

    And members of map_params_t: the float at which each table begins.
    """
    images = Images()
    steps = control_points.steps(deformation.steps_used)
    of_steps = [
        (
            kernel_arguments.control_points(step),
            step.kind.table(step).ravel(),
            region_table(step, deformation.in_rest_frame, images),
            segment_table(step),
        )
        for step in steps
    ]
    limits = limit_table(deformation.limits, control_points, images)
    points, kinds, regions, segments = map(np.concatenate, zip(*of_steps))
    sizes = [len(part) for part in of_steps[0]]
    table = np.zeros(len(steps) if len(steps) > 1 else 0, STRUCTS["step_t"])
    for k, (row, step) in enumerate(zip(table, steps)):
        for name, size in zip(("control_point", "kind_value", "region", "segment"), sizes):
            row[name] = k * size
        for name, value in step.kind.params(step).items():
            row[name] = value
    tables = [x.view("f4") for x in (points, kinds, regions, segments, limits)]
    tables += [images.table(), table.view("f4")]
    names = [f"{name}_start" for name in ("kind", "region", "segment", "limit", "image", "step")]
    return np.concatenate(tables), dict(zip(names, np.cumsum([len(part) for part in tables])))
