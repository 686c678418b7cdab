"""The kernels and the plugin are found in a checkout and in an installed wheel, and the source
distribution is enough to make that wheel."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile

import pytest
from command_fixtures import PROJECT

import vtk_mls
from vtk_mls.base.resources import resource

FOLDERS = ("opencl", "paraview_plugin")
# By Python, `make docs`, and a build.
MADE = {"__pycache__", "_build", "gallery", "made", "__init__.pyi"}

# Run by the interpreter of a fresh environment: no checkout, no vtk, no OpenCL.
INSTALLED = """
import sys
import vtk_mls
from vtk_mls.base.resources import resource

assert vtk_mls.__file__.startswith(sys.prefix), vtk_mls.__file__
for folder in ("opencl", "paraview_plugin"):
    for file in sorted(resource(folder).rglob("*")):
        if file.is_file() and "__pycache__" not in file.parts:
            print(file.relative_to(resource(folder).parent).as_posix())
moved = vtk_mls.Deformation([(0, 0, 0)], [(1, 2, 3)], device="reference")
assert moved.backward([(1, 2, 3)]).tolist() == [[0, 0, 0]]
assert "vtkmodules" not in sys.modules and "pyopencl" not in sys.modules
"""


def _files(folder):
    return {
        path.relative_to(PROJECT).as_posix()
        for path in (PROJECT / folder).rglob("*")
        if path.is_file() and not MADE & {*path.parts}
    }


def _run(*command, **options):
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(
        [str(word) for word in command],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        **options,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_checkout_finds_its_folders():
    for folder in FOLDERS:
        assert resource(folder) == PROJECT / folder


def test_a_missing_folder_has_a_remedy():
    with pytest.raises(FileNotFoundError, match=r"no folder `nowhere`.*install vtk-mls again"):
        resource("nowhere")


def test_sdist_is_complete(distributions):
    with tarfile.open(distributions[0]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    expected = {"CHANGELOG.md", "LICENSE", "Makefile", "README.md", "pyproject.toml", ".ci/run"}
    expected |= {"CITATION.cff", "CONTRIBUTING.md", ".editorconfig", ".pre-commit-config.yaml"}
    for folder in (*FOLDERS, ".github", "conda", "docs", "examples", "tests", "vtk_mls"):
        expected |= _files(folder)
    assert expected - names == set()


def test_wheel_holds_the_package_and_nothing_else(distributions):
    with zipfile.ZipFile(distributions[1]) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
        text = next(name for name in archive.namelist() if name.endswith("METADATA"))
        metadata = archive.read(text).decode()
    folders = {f"vtk_mls/{name}" for folder in FOLDERS for name in _files(folder)}
    assert names == _files("vtk_mls") | folders | {"vtk_mls/filters/__init__.pyi"}
    assert "vtk_mls/py.typed" in names
    assert "Classifier: Typing :: Typed" in metadata
    running = "Python :: {}.{}".format(*sys.version_info[:2])  # must be announced
    assert f"Classifier: Programming Language :: {running}" in metadata


def test_versions_agree():
    citation = (PROJECT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {vtk_mls.__version__}\n" in citation
    recipe = (PROJECT / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    assert f'\n  version: "{vtk_mls.__version__}"\n' in recipe
    project = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")
    for name, versions in re.findall(r"^    - ([\w-]+) (>=\S+)$", recipe, re.MULTILINE):
        is_python = name == "python"
        assert (f'python = "{versions}"' if is_python else f'"{name}{versions}') in project, name
    hooks = (PROJECT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    ruff = re.search(r'"ruff==([\d.]+)\*"', project)[1]
    assert f"rev: v{ruff}" in hooks
    changelog = (PROJECT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert vtk_mls.__version__ in re.findall(r"^## (\S+)", changelog, re.MULTILINE)


@pytest.mark.matrix
def test_wheel_in_a_fresh_environment(distributions, tmp_path):
    venv.create(tmp_path / "fresh", with_pip=True, symlinks=True)
    python = tmp_path / "fresh" / "bin" / "python"
    _run(python, "-m", "pip", "install", "--quiet", distributions[1], cwd=tmp_path)
    output = _run(python, "-W", "error", "-c", INSTALLED, cwd=tmp_path)
    assert set(output.split()) == _files("opencl") | _files("paraview_plugin")
    assert (python.parent / "vtk-mls").is_file()


# The head of the plugin file, in a Python without site-packages; beside the "script" is a clone.
PLUGIN = """
import sys

sys.path.insert(0, {folder!r})
if {early}:
    import vtk_mls
head = open({plugin!r}).read().partition("from vtk_mls.paraview import")[0]
names = {{"__file__": {plugin!r}}}
exec(compile(head, {plugin!r}, "exec"), names)
print(names["vtk_mls"].__version__, names["vtk_mls"].__file__)
"""


@pytest.mark.parametrize("early", [False, True], ids=["", "imported before"])
def test_the_plugin_takes_its_own_package_beside_a_clone(tmp_path, early):
    (tmp_path / "vtk_mls" / "vtk_mls").mkdir(parents=True)
    plugin = str(PROJECT / "paraview_plugin" / "vtk_mls_plugin.py")
    code = PLUGIN.format(folder=str(tmp_path), plugin=plugin, early=early)
    output = _run(sys.executable, "-I", "-S", "-c", code, cwd=tmp_path)
    assert output.strip() == f"{vtk_mls.__version__} {PROJECT / 'vtk_mls' / '__init__.py'}"


def test_released_pages_install_from_pypi_and_readme_links_to_addresses(tmp_path):
    shutil.copytree(PROJECT / ".ci", tmp_path / ".ci")
    shutil.copytree(PROJECT / "docs", tmp_path / "docs", ignore=shutil.ignore_patterns("_build"))
    shutil.copytree(PROJECT / "slicer", tmp_path / "slicer")
    for name in ("README.md", "pyproject.toml"):
        shutil.copy(PROJECT / name, tmp_path)
    for _ in range(2):  # the second time changes nothing
        _run(sys.executable, tmp_path / ".ci" / "addresses", "owner/name", "v1.2.3")
    readme = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert {*re.findall(r"\]\((?!https:)[^)]*", readme)} == set()
    assert (tmp_path / "pyproject.toml").read_text(encoding="utf-8").count("owner/name") == 3
    assert "git clone https://github.com/owner/name vtk_mls" in readme
    assert "pip install 'vtk-mls[vtk,cpu,web]'" in readme
    for page in (tmp_path / "README.md", *(tmp_path / "docs").rglob("*.md")):
        lines = page.read_text(encoding="utf-8").splitlines()
        assert [line for line in lines if ".[" in line or "folder of the source" in line] == []
