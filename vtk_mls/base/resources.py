"""Folders of the kernels and the ParaView plugin: in an installed wheel, or beside the package in a
checkout or an editable install."""

from pathlib import Path


def resource(name):
    """The folder of data files, "opencl" or "paraview_plugin".

    FileNotFoundError if the installation lacks it.
    """
    package = Path(__file__).resolve().parents[1]
    for folder in (package / name, package.parent / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(
        f"vtk_mls has no folder `{name}` in {package} nor beside it: install vtk-mls again"
    )
