"""Builds conda/recipe.yaml, installs the package in an empty environment, and tries it there.

Run: `python tests/environments/conda.py`, with py-rattler-build and py-rattler installed. By
default no channel is asked: one is made in build/conda of this computer's Python 3.12 and of wheels
that pip takes, so that the recipe, its dependencies and its tests are tried where conda-forge
cannot be reached. `--channel conda-forge` takes the real packages.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import shutil
import subprocess
import sys
from pathlib import Path

from rattler import Platform, install, solve
from rattler.index import index_fs
from rattler.virtual_package import VirtualPackage
from rattler_build import Package, Stage0Recipe, VariantConfig, assemble_package
from run import PROJECT, check, interpreter, run

WORK = PROJECT / "build/conda"
PYTHON = "3.12"
# What the recipe and the trial ask for, of wheels with all that they need.
OWN = ("numpy", "packaging", "typing_extensions")  # packages that several others need
WHEELS = (*OWN, "hatchling", "nibabel", "pyopencl", "vtk")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--channel", help="where packages come from, such as conda-forge")
    channel = parser.parse_args().channel
    shutil.rmtree(WORK, ignore_errors=True)
    channel = channel or local_channel(WORK / "channel")
    # packages are cached by name and version, which an older one of ours may have too
    os.environ["RATTLER_CACHE_DIR"] = str(WORK / "cache")
    package = built(channel, WORK / "output")
    tests = f"the recipe's {package.test_count} tests passed"
    print(f"{package.filename}: built, and {tests}", flush=True)
    environment = WORK / "environment"
    wanted = "vtk-mls", "vtk", f"python {PYTHON}.*"
    asyncio.run(installed(wanted, (WORK / "output", channel), environment))
    print(run(environment / "bin/vtk-mls", "doctor"))
    print(check([environment / "bin/python"], environment))


def built(channel, output):
    """The package of the recipe, tested as it says."""
    (variant,) = Stage0Recipe.from_file(PROJECT / "conda/recipe.yaml").render(VariantConfig())
    (file,) = variant.run_build(output_dir=output, channels=[str(channel)]).packages
    package = Package.from_file(file)
    for line in package.run_tests(channel=[str(channel)]):
        if not line.success:
            sys.exit("\n".join(["The recipe's tests fail:", *line.output]))
    return package


async def installed(specs, channels, environment):
    """An environment of conda packages."""
    found = await solve(
        [str(channel) for channel in channels],
        list(specs),
        platforms=[Platform.current(), Platform("noarch")],
        virtual_packages=VirtualPackage.detect(),
    )
    await install(found, target_prefix=environment)


def local_channel(folder):
    """A channel with Python and WHEELS."""
    python = Path(run(interpreter(PYTHON), "-c", "import sys; print(sys.base_prefix)").strip())
    version = run(interpreter(PYTHON), "-c", "import platform; print(platform.python_version())")
    staged = WORK / "staged"
    ignored = shutil.ignore_patterns("site-packages", "test", "__pycache__", "*.a", "idle*", "pip*")
    shutil.copytree(python, staged / "python", symlinks=True, ignore=ignored)
    pack(folder, "python", version.strip(), staged / "python", [])
    modules = Path("lib", f"python{PYTHON}", "site-packages")
    for name in ("pip", *WHEELS):
        needs = [f"python {PYTHON}.*", *(OWN if name not in (*OWN, "pip") else ())]
        place = staged / name / modules
        run(interpreter(PYTHON), "-m", "pip", "install", "--quiet", "--target", place, name)
        for other in OWN if name not in OWN else ():
            for path in place.glob(f"{other}*"):
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        (found,) = place.glob(f"{name}-*.dist-info")
        pack(folder, name, found.name.split("-")[1].removesuffix(".dist"), staged / name, needs)
    asyncio.run(index_fs(folder))
    return folder


def pack(channel, name, version, folder, needs):
    platform = str(Platform.current())
    place = channel / platform
    place.mkdir(parents=True, exist_ok=True)
    assemble_package(
        name, version, platform, "0", place, files_dir=folder, depends=needs, compression_level=1
    )


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(f"{error.cmd}: {error.stdout}")
