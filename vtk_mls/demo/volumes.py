"""Where the demo's volumes are: in packages that carry them, which are not imported."""

from __future__ import annotations

import importlib.util
from pathlib import Path


def frog():
    """The file of tissue labels (.vti) in the package pyvista.

    Raises
    ------
    FileNotFoundError
        If it is not installed, saying what to do.
    """
    return _find("pyvista", "examples/frog_tissues.vti", "0.44")


def brain():
    """The T1-weighted MNI152 brain (.nii.gz, without skull) in the package nilearn.

    Raises
    ------
    FileNotFoundError
        If it is not installed, saying what to do.
    """
    return _find(
        "nilearn", "datasets/data/mni_icbm152_t1_tal_nlin_sym_09a_converted.nii.gz", "0.8.1"
    )


def _find(package, name, version):
    spec = importlib.util.find_spec(package)
    for folder in spec.submodule_search_locations if spec else []:
        file = Path(folder) / name
        if file.is_file():
            return file
    raise FileNotFoundError(
        f"the demo's volume comes with the package {package}, {version} or later: "
        f"pip install {package}"
    )
