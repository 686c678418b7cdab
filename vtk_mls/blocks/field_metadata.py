"""The folder of a displacement field as an OME-Zarr."""

_COMPONENTS = "x", "y", "z"
_IN_LPS = "to the left", "to posterior", "to superior"
_COLORS = "FF0000", "00FF00", "0000FF"


def create_field(folder, image):
    """Create the group and the empty array of a field on the finest grid of an Image."""
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
    group.attrs.update(_attributes(image, space, version))


def _attributes(image, space, version):
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
