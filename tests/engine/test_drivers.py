"""OpenCL drivers that pip installed are found."""

import os
import shutil
import sys
from pathlib import Path

import pytest

from vtk_mls.engine.device import caches, drivers


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty folder, in which the cache folder is `cache`."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    caches.folder.cache_clear()
    yield tmp_path
    caches.folder.cache_clear()


def test_intels_driver_gets_a_path_without_spaces(cache, monkeypatch):
    folder = cache / "with space" / "lib"
    folder.mkdir(parents=True)
    driver, needed, other = (
        folder / name for name in ("libintelocl.so", "libtbb.so", "libother.so")
    )
    for file in (driver, needed, other):
        file.write_text(file.name)
    installed = {"intel-opencl-rt": [driver], "tbb": [needed]}
    monkeypatch.setattr(drivers, "_files_of", lambda package: installed.get(package, []))
    found = drivers.intel_library()
    assert found.is_relative_to(cache / "cache")
    assert {file.name for file in found.parent.iterdir()} == {driver.name, needed.name, "driver"}
    assert os.path.samefile(found, driver)
    assert drivers.intel_library() == found
    monkeypatch.setattr(os, "link", lambda *_: (_ for _ in ()).throw(OSError("another disk")))
    shutil.rmtree(found.parent)
    assert drivers.intel_library().read_text() == "libintelocl.so"
    driver.rename(cache / driver.name)  # the environment is gone, and there is another
    installed["intel-opencl-rt"] = [cache / driver.name]
    assert drivers.intel_library() == cache / driver.name
    drivers._remove_stale(found.parent.parent)
    assert not found.parent.exists()


def test_intels_driver_from_pip_is_added_to_the_systems(tmp_path, monkeypatch):
    vendors, elsewhere = tmp_path / "vendors", tmp_path / "libgpu.so"
    vendors.mkdir()
    elsewhere.write_text("")
    (vendors / "by_name.icd").write_text("libmaker.so.1\n")
    (vendors / "by_path.icd").write_text(f"{elsewhere}\n")
    (vendors / "gone.icd").write_text("/no/such/libgone.so")
    monkeypatch.setenv("OPENCL_VENDOR_PATH", str(vendors))
    monkeypatch.delenv("OCL_ICD_VENDORS", raising=False)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    library = tmp_path / "lib" / "libintelocl.so"
    monkeypatch.setattr(drivers, "intel_library", lambda: library)

    def paths():
        with drivers.registered():
            folder = Path(os.environ["OCL_ICD_VENDORS"])
            found = sorted(icd.read_text().strip() for icd in folder.glob("*.icd"))
        assert "OCL_ICD_VENDORS" not in os.environ
        assert not folder.exists()
        return found

    assert paths() == sorted([str(elsewhere), str(library), "libmaker.so.1"])
    (vendors / "intel.icd").write_text("libintelocl.so\n")  # the system's own
    assert paths() == sorted([str(elsewhere), "libintelocl.so", "libmaker.so.1"])
    monkeypatch.setenv("OCL_ICD_VENDORS", "/chosen")
    with drivers.registered():
        assert os.environ["OCL_ICD_VENDORS"] == "/chosen"


def test_the_lock_of_a_killed_process_is_removed(cache):
    lock = Path(caches.kernel_folder(), "lock")
    lock.parent.mkdir(parents=True)
    lock.touch()
    caches.kernel_folder()
    assert lock.exists()  # a build in another process
    os.utime(lock, (0, 0))
    caches.kernel_folder()
    assert not lock.exists()
