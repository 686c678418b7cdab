"""Pairs of landmarks: how good they are, and how images refine them.

Errors when left out, outliers, swapped labels, settings; the best match of the images around them.
"""

from vtk_mls.landmarks.left_out import Settings
from vtk_mls.landmarks.pair_report import Report, report
from vtk_mls.landmarks.refinement import Image, Refinement, refine

__all__ = ["Image", "Refinement", "Report", "Settings", "refine", "report"]
