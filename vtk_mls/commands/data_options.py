"""Options of `vtk-mls deform` and `vtk-mls field` that are for some kinds of data only."""

from vtk_mls.files.block_files import blocks

IMAGES, MESHES, OME_ZARR = "images", "meshes", "OME-Zarr"
_ONE = {IMAGES: "an image", MESHES: "a mesh", OME_ZARR: "an OME-Zarr, written block by block"}
_ONLY = {  # option and kinds of data, by attribute of the options
    "interpolation": ("--interpolation", (IMAGES, OME_ZARR)),
    "background": ("--background", (IMAGES, OME_ZARR)),
    "label_arrays": ("--label", (IMAGES, OME_ZARR)),
    "output_grid": ("--grid", (IMAGES,)),
    "reference": ("--reference", (IMAGES,)),
    "gradient_array": ("--gradient", (IMAGES,)),
    "generate_overlap": ("--overlap", (IMAGES,)),
    "generate_cell_quality": ("--cell-quality", (MESHES,)),
    "inverse": ("--inverse", (IMAGES, MESHES)),
    "jacobian": ("--jacobian", (IMAGES, MESHES)),
    "dimensions": ("--dimensions", (MESHES,)),
    "spacing_factor": ("--spacing-factor", (IMAGES, MESHES)),
}


def check(options, *kinds):
    """Raise ValueError for an option that has no effect on data of these kinds."""
    for name, (flag, allowed) in _ONLY.items():
        is_given = getattr(options, name, None) != options.parser.get_default(name)
        if is_given and kinds and not set(kinds) & set(allowed):
            raise ValueError(
                f"`{flag}` is for {' and '.join(allowed)}: `{options.input}` is "
                f"{_ONE[kinds[0]]}; leave it out"
            )


def kinds_of(dataset):
    """The kinds of a vtkDataObject and its blocks."""
    return [IMAGES if block.IsA("vtkImageData") else MESHES for block in blocks(dataset)]
