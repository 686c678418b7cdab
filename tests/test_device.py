"""Choice of the device and errors of its driver."""

import dataclasses

import pytest
from conftest import DEVICES

from vtk_mls import Deformation, DeviceError, device, dispatch, reference

ONE = ([[0, 0, 0]], [[1, 0, 0]])
GPU = device.Device("0:0", "Fast", "Some", "gpu", "OpenCL 3.0", None)
CPU = device.Device("1:0", "Slow", "Other", "cpu", "OpenCL 3.0", None)


@pytest.fixture
def found(monkeypatch):
    """Pretend that these devices are there, all of them sound."""

    def pretend(*devices, defects=()):
        monkeypatch.setattr(device, "_find", lambda: (list(devices), "OpenCL has no device"))
        monkeypatch.setattr(device, "defect", lambda d: "it is broken" if d in defects else None)

    return pretend


def test_first_gpu_else_first_cpu(found):
    found(CPU, GPU)
    assert device.choose() is GPU
    assert device.choose("cpu") is CPU
    assert device.choose("1:0") is CPU
    found(CPU)
    assert device.choose() is CPU


def test_a_device_that_builds_nothing_is_passed_over(found):
    second = dataclasses.replace(CPU, key="2:0")
    found(GPU, CPU, second, defects=[GPU, CPU])
    assert device.choose() is second
    found(CPU, defects=[CPU])
    with pytest.raises(DeviceError, match=r"that works; found 1:0 Slow .*is broken; install"):
        device.choose()


def test_errors_list_what_there_is(found):
    found(CPU)
    with pytest.raises(DeviceError, match=r"no OpenCL device `gpu`; found 1:0 Slow \(cpu, Other\)"):
        device.choose("gpu")
    found()
    with pytest.raises(DeviceError, match=r"no OpenCL device found: .*pyopencl\[pocl\]"):
        device.choose()


def test_without_pyopencl(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyopencl", None)
    assert device.list_devices() == []
    with pytest.raises(DeviceError, match="pyopencl cannot be imported"):
        device.choose()
    d = Deformation(*ONE, device="cpu")  # a value needs no device
    with pytest.raises(DeviceError, match="pyopencl cannot be imported"):
        d.backward([[0, 0, 0]])


def test_the_environment_is_asked_after_the_argument(monkeypatch):
    monkeypatch.setenv("VTK_MLS_DEVICE", "reference")
    assert dispatch.engine_for() is reference
    monkeypatch.setenv("VTK_MLS_DEVICE", "7:7")
    assert dispatch.engine_for("reference") is reference
    with pytest.raises(DeviceError, match="no OpenCL device `7:7`"):
        dispatch.engine_for()


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that builds kernels")
def test_build_errors_are_readable():
    chosen = device.choose(DEVICES[0])
    with pytest.raises(DeviceError, match=r"map.cl do not build on .*LANES is missing"):
        device.program(chosen, "map.cl", ())


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that builds kernels")
def test_sound_devices_have_no_defect():
    assert device.defect(device.choose(DEVICES[0])) is None


def test_sources_are_one_text():
    text = device.source("map.cl")
    assert "#include" not in text
    assert text.count("inline quaternion_t whole_rotation") == 1


@pytest.mark.parametrize("launcher", device._PROCESS_VARIABLES)
def test_processes_share_out_the_gpus_of_a_node(found, launcher, monkeypatch):
    cards = [dataclasses.replace(GPU, key=f"0:{number}") for number in range(3)]
    found(CPU, *cards)
    for rank in range(5):
        for name, value in zip(launcher, (rank, 5)):
            monkeypatch.setenv(name, str(value))
        assert device.choose() is device.choose("gpu") is cards[rank % 3]
        assert device.choose("0:1") is cards[1]
        assert device.choose("cpu") is CPU
        assert device.sharers(cards[0]) == 2
        assert device.sharers(CPU) == 1
    found(*cards, defects=[cards[1]])
    assert device.choose() is cards[2]
