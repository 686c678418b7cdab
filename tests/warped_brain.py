"""A brain, the same brain warped by a B-spline of SimpleITK, and how well landmarks match them."""

from __future__ import annotations

import numpy as np
from opened_brain import NAME, copy_to

TARGET = "subject.nii.gz"
_SEED, _STRENGTH = 5, 14.0  # mm, of the coefficients of the B-spline
_SPACING = 12.0  # mm, of the held-out points


class WarpedBrain:
    """The brain and its target in a folder.

    Parameters
    ----------
    folder : Path
        Gets both files.
    """

    def __init__(self, folder):
        import SimpleITK as sitk

        copy_to(folder)
        brain = sitk.ReadImage(str(folder / NAME))
        self._warp = sitk.BSplineTransformInitializer(brain, [2, 2, 2])
        rng, count = np.random.default_rng(_SEED), len(self._warp.GetParameters())
        self._warp.SetParameters((_STRENGTH * rng.standard_normal(count)).tolist())
        target = sitk.Resample(brain, brain, self._warp, sitk.sitkLinear, 0.0)
        sitk.WriteImage(target, str(folder / TARGET))
        tissue = sitk.GetArrayViewFromImage(target) > 0
        index = np.argwhere(tissue[tuple(slice(None, None, self._step(brain)) for _ in range(3))])
        index = index[:, ::-1] * self._step(brain)
        self.held_out = np.array(
            [target.TransformIndexToPhysicalPoint([*map(int, i)]) for i in index]
        )

    @staticmethod
    def _step(image):
        return round(_SPACING / image.GetSpacing()[0])

    def partners(self, points):
        """The places (n, 3) on the brain of points (n, 3) of the target, LPS."""
        return np.array([self._warp.TransformPoint(point) for point in np.array(points).tolist()])
