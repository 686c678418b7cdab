"""Landmarks of a `State`, refined by the images around them."""

from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import landmarks
from vtk_mls.editor.scene_image import scalar_image
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


def image_of(dataset, side):
    """The `landmarks.Image` of a dataset; ValueError, naming the side, without gray values."""
    if not isinstance(dataset, vtkImageData):
        raise ValueError(
            f"landmarks are refined by two images with gray values, and the {side} is a mesh"
        )
    image = scalar_image(dataset)
    scalars, grid = image.GetPointData().GetScalars(), ImageGeometry.of_image(image).grid
    return landmarks.Image(arrays.to_numpy(scalars).reshape(grid.shape), grid)


def refined(state, datasets, rows, progress=None):
    """A `State` with refined landmarks `rows`, and the `landmarks.Refinement`.

    `datasets` are the moving one and the target; errors and `progress` are as of
    `landmarks.refine`.
    """
    moving, target = (
        image_of(dataset, side) for dataset, side in zip(datasets, ("moving data", "target"))
    )
    deformation = state.deformation() if state.enabled.any() else None
    found = landmarks.refine(
        moving,
        target,
        state.rest[rows],
        state.deformed[rows],
        deformation=deformation,
        progress=progress,
    )
    return state.moved(rows, found.deformed), found


def key_of(state, row):
    """Identifies a landmark by its places, whatever its row and name."""
    return state.rest[row].tobytes() + state.deformed[row].tobytes()
