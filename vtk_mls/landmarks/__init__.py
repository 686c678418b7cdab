"""How good pairs of landmarks are: errors when left out, outliers, swapped labels, settings."""

from vtk_mls.landmarks.pair_report import Report, report
from vtk_mls.landmarks.settings import Settings

__all__ = ["Report", "Settings", "report"]
