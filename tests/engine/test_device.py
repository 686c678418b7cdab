"""Choice of the device and errors of its driver."""

import dataclasses
import multiprocessing
import types

import pyopencl as cl
import pytest
from control_point_sets import DEVICES, LOCAL_POINTS, OTHER_DEVICES
from pyopencl import characterize

from vtk_mls import Deformation, DeviceError
from vtk_mls.base.resources import resource
from vtk_mls.engine import dispatch
from vtk_mls.engine import opencl_engine as engine
from vtk_mls.engine.device import caches, device_check, quirks
from vtk_mls.engine.device import devices as device
from vtk_mls.engine.launch.launcher import Launcher
from vtk_mls.reference import reference_engine as reference

ONE = ([[0, 0, 0]], [[1, 0, 0]])
GPU = device.Device("0:0", "Fast", "Some", "gpu", "OpenCL 3.0", None)
CPU = device.Device("1:0", "Slow", "Other", "cpu", "OpenCL 3.0", None)
GOOD = device_check.Result()
BAD = device_check.Result("it is broken")

needs_device = pytest.mark.skipif(
    not DEVICES, reason="no OpenCL device that computes right: `vtk-mls doctor` says why"
)


@pytest.fixture(autouse=True)
def no_choice():
    """As in a process that has chosen no device."""
    dispatch._chosen.cache_clear()
    yield
    dispatch._chosen.cache_clear()


@pytest.fixture
def found(monkeypatch):
    """Replace the devices of the machine and the results of their checks, good unless given."""

    def pretend(*devices, **results):
        by_key = {d.key: results.get(d.name.lower(), GOOD) for d in devices}
        monkeypatch.setattr(device, "_in_use", [])  # other tests of the process use drivers
        monkeypatch.setattr(device, "find", lambda: (list(devices), "OpenCL has no device"))
        monkeypatch.setattr(device_check, "failure", lambda d: by_key[d.key].failure)
        monkeypatch.setattr(
            device_check, "results", lambda found, subjects: [by_key[d.key] for d in found]
        )

    return pretend


def key_of(chosen):
    return chosen and chosen.key


def test_first_gpu_else_fastest_cpu(found):
    found(CPU, GPU)
    assert key_of(dispatch.choose()) == GPU.key
    assert key_of(dispatch.choose("cpu")) == CPU.key
    assert key_of(dispatch.choose("1:0")) == CPU.key
    found(CPU)
    assert key_of(dispatch.choose()) == CPU.key


def test_no_driver_is_checked_after_the_first_that_works(found, monkeypatch):
    intel, pocl = (
        dataclasses.replace(CPU, key=key, name=name, platform=platform)
        for key, name, platform in (("3:0", "Intel", quirks.INTEL), ("2:0", "PoCL", quirks.POCL))
    )
    checked = []

    def choose(name=None, **bad):
        found(CPU, pocl, intel, **bad)
        results = device_check.results
        monkeypatch.setattr(
            device_check, "results", lambda found, _: checked.extend(found) or results(found, _)
        )
        checked.clear()
        return dispatch.choose(name)

    for name in (None, "cpu"):
        assert choose(name) == intel
        assert checked == [intel]
        assert choose(name, intel=BAD) == pocl
        assert checked == [intel, pocl]
        assert choose(name, intel=BAD, pocl=BAD) == CPU
    choose(intel=BAD)
    checked.clear()
    assert dispatch.choose(is_checked=False) == pocl
    monkeypatch.setattr(device_check, "failure", lambda device: "")
    assert dispatch.choose(is_checked=False) == intel
    assert checked == []


def test_the_reference_is_used_if_all_devices_fail(found, caplog):
    dispatch._warn_once.cache_clear()
    found(CPU, slow=BAD)
    assert dispatch.engine_for() is reference
    dispatch.engine_for()
    assert len(caplog.messages) == 1
    assert caplog.text.count("numpy is used, slowly: no OpenCL device that works; found 1:0") == 1


def test_a_named_device_is_never_replaced(found):
    found(GPU, CPU, fast=BAD)
    for name in ("0:0", "gpu"):
        with pytest.raises(
            DeviceError, match=rf"no OpenCL device `{name}` that works; found .* it is broken"
        ):
            dispatch.choose(name)


def test_errors_list_the_devices(found):
    found(CPU)
    with pytest.raises(DeviceError, match=r"no OpenCL device `gpu`; found 1:0 Slow \(cpu, Other\)"):
        dispatch.choose("gpu")
    found()
    install = r"pip install 'vtk-mls\[cpu\]' .*; or use device=\"reference\"$"
    for name, words in ((None, "that works"), ("cpu", "`cpu`")):
        with pytest.raises(DeviceError, match=f"no OpenCL device {words}: OpenCL .*{install}"):
            dispatch.choose(name)


def test_without_pyopencl(monkeypatch, caplog):
    monkeypatch.setitem(__import__("sys").modules, "pyopencl", None)
    monkeypatch.setattr(device, "_listed", device._listed.__wrapped__)
    assert device.list_devices() == []
    dispatch._warn_once.cache_clear()
    d = Deformation(*ONE)
    assert [d.backward([[0, 0, 0]]).tolist() for _ in range(2)] == [[[-1, 0, 0]]] * 2
    (sentence,) = caplog.messages
    assert "numpy is used, slowly: no OpenCL device that works: pyopencl cannot" in sentence
    assert "'vtk-mls[cpu]'" in sentence
    assert 'device="reference"' in sentence
    d = Deformation(*ONE, device="cpu")  # a value needs no device
    with pytest.raises(DeviceError, match="pyopencl cannot be imported"):
        d.backward([[0, 0, 0]])


def test_the_argument_precedes_the_environment(monkeypatch):
    monkeypatch.setenv("VTK_MLS_DEVICE", "reference")
    assert dispatch.engine_for() is reference
    monkeypatch.setenv("VTK_MLS_DEVICE", "7:7")
    assert dispatch.engine_for("reference") is reference
    with pytest.raises(DeviceError, match="no OpenCL device `7:7`"):
        dispatch.engine_for()


def test_a_folder_left_by_an_uninstalled_pyopencl(monkeypatch):
    folder = types.ModuleType("pyopencl")
    folder.__path__ = ["/somewhere/pyopencl"]
    monkeypatch.setitem(__import__("sys").modules, "pyopencl", folder)
    monkeypatch.setattr(device, "_listed", device._listed.__wrapped__)
    devices, problem = device.find()
    assert devices == []
    assert "/somewhere/pyopencl has no pyopencl: install it again" in problem


def of_width(native, kind, platform, version="OpenCL 3.0", driver="", key="0:0"):
    handle = types.SimpleNamespace(native_vector_width_float=native)
    return device.Device(key, "D", platform, kind, version, handle, driver)


def pocl(key, driver, target, native=16):
    version = f"OpenCL 3.0 PoCL HSTR: {target}"
    return of_width(native, "cpu", quirks.POCL, version, driver, key)


WITHOUT_AVX512, WITH_AVX512 = "pthread-x86_64-linux-gnu-znver3", "cpu-x86_64-skylake-avx512"


@pytest.mark.parametrize(
    ("found", "lanes", "double"),
    [
        (pocl("0:0", "3.0, OpenCL 3.0 PoCL 3.0  Linux", WITHOUT_AVX512, 16), 8, 4),
        (pocl("0:0", "3.0, OpenCL 3.0 PoCL 3.0  Linux", "pthread-x86_64-haswell", 8), 8, 4),
        (pocl("0:0", "3.1, OpenCL 3.0 PoCL 3.1", WITH_AVX512, 16), 16, 16),
        (pocl("0:0", "6.0, OpenCL 3.0 PoCL 6.0", WITHOUT_AVX512, 16), 16, 16),
        (of_width(16, "cpu", quirks.INTEL), 16, 16),
        (of_width(8, "cpu", quirks.INTEL), 8, 8),
        (of_width(1, "cpu", quirks.INTEL), 4, 4),
        (of_width(16, "cpu", "Unknown"), 4, 4),
        (of_width(16, "gpu", quirks.INTEL), 1, 1),
        (of_width(4, "accelerator", "Unknown"), 1, 1),
    ],
)
def test_the_width_of_vectors(found, lanes, double):
    assert (found.lanes, found.double_lanes) == (lanes, double)
    assert dataclasses.replace(found, width=2).lanes == 2


def test_a_device_of_all_types_is_a_cpu():
    types_ = cl.device_type
    platform = types.SimpleNamespace(name="Simulator", version="1")

    def kind(type_):
        handle = types.SimpleNamespace(type=type_, name="D", version="V", driver_version="1")
        return device._device("0:0", platform, handle).kind

    assert kind(types_.CPU | types_.GPU | types_.ACCELERATOR | types_.DEFAULT) == "cpu"
    assert kind(types_.GPU | types_.DEFAULT) == "gpu"
    assert kind(types_.ACCELERATOR) == "accelerator"


def test_one_pocl_at_a_time(monkeypatch):
    first, second = pocl("0:0", "3.0", "a"), pocl("1:0", "3.1", "b")
    monkeypatch.setattr(device, "_in_use", [first, CPU])
    assert device.is_free(first)
    assert device.is_free(CPU)
    assert not device.is_free(second)
    with pytest.raises(DeviceError, match=r"^1:0 .* another Portable Computing Language already"):
        device.context(second)


@needs_device
def test_build_errors_are_readable():
    chosen = dispatch.choose(DEVICES[0])
    with pytest.raises(DeviceError, match=r"point_jacobian does not build on .*LANES is missing"):
        device.kernel(chosen, "point_jacobian", ())


@needs_device
def test_a_broken_cache_entry_is_rebuilt(monkeypatch):
    texts = []

    class Program(cl.Program):
        def build(self, *arguments, **options):
            texts.append(self._source if hasattr(self, "_source") else "")
            built = super().build(*arguments, **options)
            if len(texts) == 1:
                raise EOFError("Ran out of input")
            return built

    monkeypatch.setattr(cl, "Program", Program)
    chosen = dispatch.choose(DEVICES[0])
    assert (
        device.kernel(chosen, "local_points", (*LOCAL_POINTS, ("UNLIKE_ANY", 1))).function_name
        == "local_points"
    )
    assert len(texts) == 2
    assert texts[0] != texts[1]


@needs_device
@pytest.mark.parametrize("key", DEVICES + OTHER_DEVICES)
def test_pyopencl_keeps_no_kernels_of_pocl(key, monkeypatch, tmp_path):
    monkeypatch.setattr(characterize, "has_src_build_cache", lambda _: False)  # as in old versions
    monkeypatch.setattr(caches, "kernel_folder", lambda: str(tmp_path))
    chosen = dispatch.choose(key)
    device.kernel(chosen, "local_points", (*LOCAL_POINTS, ("UNLIKE_OTHERS", 1)))
    assert any(tmp_path.iterdir()) == (chosen.platform != quirks.POCL)


def driver_error(kind, code):
    return kind(cl._cl._ErrorRecord("clSomething", code, ""))


@needs_device
def test_driver_errors_are_sentences(monkeypatch):
    chosen = dispatch.choose(DEVICES[0])

    def refuse(*_, **__):
        raise driver_error(cl.LogicError, cl.status_code.INVALID_WORK_GROUP_SIZE)

    monkeypatch.setattr(Launcher, "launch", refuse)
    with pytest.raises(DeviceError, match=rf"driver of {DEVICES[0]} .* INVALID_WORK_GROUP_SIZE"):
        Deformation(*ONE, device=DEVICES[0]).backward([[0, 0, 0]])
    monkeypatch.undo()
    assert dispatch.engine_for(DEVICES[0]) is engine.on(chosen)
    assert Deformation(*ONE, device=DEVICES[0]).backward([[0, 0, 0]]).tolist() == [[-1, 0, 0]]


@needs_device
def test_out_of_memory_is_retried_in_smaller_slabs(monkeypatch):
    used = engine.on(dispatch.choose(DEVICES[0]))
    monkeypatch.setattr(used.memory, "limit", 1 << 26)
    monkeypatch.setattr(used.memory, "in_place", False)
    d = Deformation(*ONE, device=DEVICES[0])
    whole = d.displacement_field((64, 64, 200)).displacement
    sizes, buffer = [], cl.Buffer

    def limited(context, flags, size=0, hostbuf=None):
        sizes.append(size or hostbuf.nbytes)
        if sizes[-1] > 2e6:
            raise driver_error(cl.MemoryError, cl.status_code.MEM_OBJECT_ALLOCATION_FAILURE)
        return buffer(context, flags, size, hostbuf)

    monkeypatch.setattr(cl, "Buffer", limited)
    assert (d.displacement_field((64, 64, 200)).displacement == whole).all()
    assert max(sizes) > 2e6
    monkeypatch.setattr(used.memory, "limit", 1000)
    monkeypatch.setattr(cl, "Buffer", lambda *_, **__: limited(None, None, 1 << 40))
    with pytest.raises(DeviceError, match="does not have enough memory"):
        d.backward([[1, 2, 3]])


def _evaluate_in_fork(answers):
    try:
        answers.put(Deformation(*ONE, device=DEVICES[0]).backward([[0, 0, 0]]).tolist())
    except DeviceError as error:
        answers.put(str(error))


@needs_device
@pytest.mark.skipif(
    "fork" not in multiprocessing.get_all_start_methods(), reason="this system has no fork"
)
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_fork_gets_an_error():
    Deformation(*ONE, device=DEVICES[0]).backward([[0, 0, 0]])
    forks = multiprocessing.get_context("fork")
    answers = forks.Queue()
    child = forks.Process(target=_evaluate_in_fork, args=(answers,))
    child.start()
    answer = answers.get(timeout=60)
    child.join()
    assert "forked" in answer
    assert "spawn" in answer


@pytest.mark.filterwarnings("ignore")  # output of the compiler
def test_functions_that_no_kernel_calls_are_not_built(key):
    text = device.source("local_points.cl", LOCAL_POINTS)
    (binary,) = cl.Program(device.context(dispatch.choose(key)), text).build().binaries
    assert "cross3(" in text
    assert b"local_points" in binary
    assert b"cross3" not in binary


def test_kernel_files_have_names_of_their_own():
    """`#include` finds them by name in all folders."""
    paths = list(resource("opencl").rglob("*.[ch]*"))
    assert len({path.name for path in paths}) == len(paths)


@pytest.mark.parametrize("launcher", device._PROCESS_VARIABLES)
def test_processes_share_the_gpus_of_a_node(found, launcher, monkeypatch):
    cards = [dataclasses.replace(GPU, key=f"0:{number}") for number in range(3)]
    found(CPU, *cards)
    for rank in range(5):
        for name, value in zip(launcher, (rank, 5)):
            monkeypatch.setenv(name, str(value))
        assert key_of(dispatch.choose()) == key_of(dispatch.choose("gpu")) == cards[rank % 3].key
        assert key_of(dispatch.choose("0:1")) == "0:1"
        assert key_of(dispatch.choose("cpu")) == CPU.key
        assert device.sharers(cards[0]) == 2
        assert device.sharers(CPU) == 1
    broken = dataclasses.replace(cards[1], name="Broken")
    found(cards[0], broken, cards[2], broken=BAD)
    assert key_of(dispatch.choose()) == cards[2].key
