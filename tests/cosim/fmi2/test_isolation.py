"""FMUs in processes of their own: the same bits, and faults that end a component with a sentence, not the master."""

from __future__ import annotations

import errno
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim import Component, Connection, Constant, Method, Scenario, System, load_scenario, simulate
from cosim.cli.app import app
from cosim.errors import FmuFileError, LostSlaveError, RunError, SlaveError, SystemDefinitionError
from cosim.fmi2.isolation import Limits
from cosim.fmi2.isolation.isolated_slave import open_isolated_fmu
from cosim.fmi2.model_description import read_description
from cosim.recording.record import allocate_block
from cosim.recording.result import Result

pytestmark = pytest.mark.slow

LIMITS = Limits(time=2.0, memory=64e6)
SEGFAULT, ABORT, EXIT, HANG, GROW, DEMAND, SHOUT = range(10, 17)

FAULTS = [
    (SEGFAULT, r"crashed in fmi2DoStep \(SIGSEGV\)"),
    (ABORT, r"crashed in fmi2DoStep \(SIGABRT\)"),
    (EXIT, r"ended its process in fmi2DoStep \(exit code 3\)"),
    (HANG, r"hung in fmi2DoStep and was stopped after 2 s"),
]
PLACES = [
    ("set", 0.0, "while its inputs were set"),
    ("get", 0.0, "while its outputs were read"),
    ("exit", 0.0, "in fmi2ExitInitializationMode"),
    ("terminate", 1.0, "in fmi2Terminate"),
]


def scenario(fmu: Path, *, name: str = "guest", stop_time: float = 1.0, **parameters: float | str) -> Scenario:
    """The probe on a constant input."""
    system = System((Component(name, fmu, parameters),), inputs={f"{name}.u": Constant(2.0)})
    return Scenario("isolation", system, stop_time=stop_time, step_size=0.1)


def same_bits(one: Result, other: Result) -> bool:
    return one.names == other.names and all(one[name].tobytes() == other[name].tobytes() for name in one.names)


@pytest.mark.parametrize(
    ("name", "algorithm", "packaging"),
    [
        ("wob-law", "jacobi", "native"),
        ("wob-law", "gauss-seidel", "python"),
        ("dissipative-law", "gauss-seidel", "native"),
        ("dissipative-law", "jacobi", "python"),
    ],
)
def test_isolated_components_give_the_same_bits(name: str, algorithm: str, packaging: str) -> None:
    loaded = load_scenario(name)
    arguments = {"algorithm": algorithm, "packaging": packaging, "step_size": 0.02, "stop_time": 3.0}
    alone = simulate(loaded, **arguments)
    isolated = simulate(loaded, **arguments, isolate=True)
    assert same_bits(alone, isolated)
    assert isolated.record["isolated"] == sorted(part.name for part in loaded.system.components)


@pytest.mark.parametrize("method", [Method("implicit"), Method("implicit", tolerance=1e-3)], ids=["fixed", "variable"])
def test_isolated_components_whose_steps_are_repeated_give_the_same_bits(method: Method) -> None:
    loaded = replace(load_scenario("dissipative-law"), method=method)
    arguments = {"variant": "tracking", "step_size": 0.02, "stop_time": 3.0}
    alone = simulate(loaded, **arguments)
    isolated = simulate(loaded, **arguments, isolate=True)
    assert alone.record["iterations"]["most"] > 1
    assert same_bits(alone, isolated)


def test_one_isolated_component_among_others_gives_the_same_bits() -> None:
    loaded = load_scenario("wob-law")
    alone = simulate(loaded, stop_time=2.0)
    isolated = simulate(loaded, stop_time=2.0, isolate=["plant"])
    assert same_bits(alone, isolated)
    assert isolated.record["isolated"] == ["plant"]


def test_values_of_every_type_arrive(probe: Path) -> None:
    inputs = {"a.u": Constant(0.1), "a.n": Constant(7), "a.flag": Constant(True)}
    connections = (Connection("a.n_next", "b.n"), Connection("a.not_flag", "b.flag"), Connection("a.u_seen", "b.u"))
    parameters = {"gain": 3.0, "mode": "fast", "text": "a word"}
    system = System((Component("a", probe, parameters), Component("b", probe)), connections, inputs)
    coupled = Scenario("types", system, stop_time=1.0, step_size=0.1, method=Method("gauss-seidel"))
    assert same_bits(simulate(coupled), simulate(coupled, isolate=True))


@pytest.mark.parametrize("order", [("offering", "dividing"), ("dividing", "offering")])
def test_an_input_without_a_start_value_begins_with_what_it_is_in_the_isolated_fmu(
    make_probe: Callable[..., Path], order: tuple[str, ...]
) -> None:
    old = 'name="u" valueReference="0" causality="input"><Real start="0"'
    probe = make_probe(replace={old: old.replace('start="0"', "")})
    connection = Connection("offering.u_seen", "dividing.u")  # which fails if its u is 0
    system = System(tuple(Component(name, probe) for name in order), (connection,), {"offering.u": Constant(5.0)})
    coupled = Scenario("start", system, stop_time=1.0, step_size=0.1)
    isolated = simulate(coupled, isolate=True)
    assert isolated["dividing.u"].tolist() == [5.0] * 11
    assert same_bits(simulate(coupled), isolated)


@pytest.mark.parametrize(("fault", "how"), FAULTS)
def test_a_fault_in_a_step_is_told_with_instance_time_and_kind(
    probe: Path, no_leftovers: Path, fault: int, how: str
) -> None:
    with pytest.raises(LostSlaveError, match=rf"^guest at t = 0\.40 s: the FMU {how}$") as caught:
        simulate(scenario(probe, fail_at=0.35, fail_status=fault), isolate=True, limits=LIMITS)
    assert caught.value.component == "guest"
    assert caught.value.time == pytest.approx(0.4)


@pytest.mark.parametrize(("place", "when", "where"), PLACES)
def test_a_crash_elsewhere_is_told_with_its_place(
    probe: Path, no_leftovers: Path, place: str, when: float, where: str
) -> None:
    with pytest.raises(LostSlaveError) as caught:
        simulate(scenario(probe, text=place, fail_status=ABORT), isolate=True)
    assert str(caught.value) == f"guest at t = {when:.2f} s: the FMU crashed {where} (SIGABRT)"


def test_a_crash_at_instantiation_is_told(probe: Path, no_leftovers: Path) -> None:
    with pytest.raises(RunError, match=r"crashing: the FMU crashed while it was loaded and instantiated \(SIGABRT\)"):
        simulate(scenario(probe, name="crashing"), isolate=True)


def test_a_crash_at_the_end_keeps_the_results(
    probe: Path, no_leftovers: Path, caplog: pytest.LogCaptureFixture
) -> None:
    result = simulate(scenario(probe, text="free", fail_status=ABORT), isolate=True)
    assert result["guest.integral"][-1] == pytest.approx(2.0)
    assert "guest: the FMU crashed while it was freed and unloaded (SIGABRT)" in caplog.text


@pytest.mark.skipif(sys.platform == "win32", reason="there the memory of a process is not watched")
def test_growth_is_stopped_at_the_limit(probe: Path, no_leftovers: Path) -> None:
    expected = r"guest at t = 0\.40 s: the FMU was stopped in fmi2DoStep because it held \d+ MB of memory; expected at"
    with pytest.raises(LostSlaveError, match=rf"{expected} most 64 MB$"):
        simulate(scenario(probe, fail_at=0.35, fail_status=GROW), isolate=True, limits=Limits(memory=64e6))


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux refuses address space")
def test_a_demand_beyond_the_limit_fails_in_the_fmu(probe: Path) -> None:
    with pytest.raises(SlaveError, match=r"fmi2DoStep returned fmi2Error: there is no memory left at 0\.4 s"):
        simulate(scenario(probe, fail_at=0.35, fail_status=DEMAND), isolate=True, limits=LIMITS)


def test_a_failed_step_reads_as_it_does_without_isolation(probe: Path) -> None:
    told: list[str] = []
    for isolate in (False, True):
        with pytest.raises(SlaveError) as caught:
            simulate(scenario(probe, fail_at=0.35, fail_status=3), isolate=isolate)
        told.append(str(caught.value))
    assert told[0] == told[1] == "guest at t = 0.40 s: fmi2DoStep returned fmi2Error: the probe gave up at 0.4 s"


def test_messages_of_an_isolated_fmu_are_logged(probe: Path, caplog: pytest.LogCaptureFixture) -> None:
    simulate(scenario(probe), isolate=True)
    assert ("cosim.fmi2.guest", "ready at 1.5") in [(record.name, record.getMessage()) for record in caplog.records]


def test_what_the_fmu_prints_does_not_disturb(probe: Path) -> None:
    quiet = scenario(probe)
    loud = scenario(probe, text="get", fail_status=SHOUT)
    assert same_bits(simulate(quiet), simulate(loud, isolate=True))


def test_an_fmu_that_is_refused_is_refused_alike(make_probe: Callable[..., Path]) -> None:
    told: list[str] = []
    path = make_probe(folder="riscv64-linux")
    for isolate in (False, True):
        with pytest.raises(FmuFileError, match="it has binaries for riscv64-linux") as caught:
            simulate(scenario(path), isolate=isolate)
        told.append(str(caught.value))
    assert told[0] == told[1]


def test_isolated_instances_of_a_once_per_process_fmu_are_allowed(make_probe: Callable[..., Path]) -> None:
    path = make_probe(replace={'canInterpolateInputs="true"': 'canBeInstantiatedOnlyOncePerProcess="true"'})
    system = System((Component("first", path), Component("second", path, isolate=True)))
    result = simulate(Scenario("twice", system, stop_time=0.2, step_size=0.1))
    assert result.record["isolated"] == ["second"]


def test_a_component_to_isolate_must_exist(probe: Path) -> None:
    with pytest.raises(SystemDefinitionError, match="there is no component 'gast' to isolate; did you mean 'guest'"):
        simulate(scenario(probe), isolate=["gast"])


def test_a_restored_state_repeats_the_same_bits(probe: Path) -> None:
    description = read_description(probe)
    with open_isolated_fmu("guest", probe, description) as slave:
        block = allocate_block(description, ["u"], {}, 3)
        slave.setup(block, {}, 0.0, 1.0)
        slave.enter_initialization()
        slave.exit_initialization()
        block.inputs["Real"].values[1:, 0] = 2.0, 4.0
        found: list[float] = []
        slave.save(0)
        for row in (1, 2, 1):
            slave.write(row)
            slave.step(0.0, 0.1)
            slave.read(row)
            found.append(float(block.outputs["Real"].values[row, 0]))
            slave.restore(0)
        slave.read(0)
        assert found == [0.1 * 2.0, 0.1 * 4.0, 0.1 * 2.0]
        assert block.outputs["Real"].values[0, 0] == 0.0


def test_the_process_outlives_the_thread_that_started_it(probe: Path) -> None:
    description = read_description(probe)
    with ExitStack() as stack, ThreadPoolExecutor(1) as pool:
        slave = pool.submit(stack.enter_context, open_isolated_fmu("guest", probe, description)).result()
        pool.shutdown()
        block = allocate_block(description, ["u"], {}, 2)
        slave.setup(block, {}, 0.0, 1.0)
        slave.enter_initialization()
        slave.exit_initialization()
        slave.step(0.0, 0.1)


def test_that_no_process_can_be_started_is_told(probe: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EAGAIN, "Resource temporarily unavailable")

    monkeypatch.setattr("subprocess.Popen", refuse)
    told = "^guest: no process can be started for the FMU: Resource temporarily unavailable$"
    with pytest.raises(RunError, match=told):
        simulate(scenario(probe), isolate=True)


TOML = """
stop_time = 1e6
step_size = 0.001

[components.guest]
fmu = "probe.fmu"
isolate = true
"""


@pytest.fixture
def running(probe: Path, tmp_path: Path):
    """A long run with an isolated FMU, and the number of its process."""
    if sys.platform != "linux":
        pytest.skip("children are looked up in /proc")
    (tmp_path / "guest.toml").write_text(TOML.replace("1e6", "1000"))
    command = [sys.executable, "-m", "cosim", "run", "guest.toml"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    while not (found := [each for each in descendants_of(process.pid) if is_stepping(each)]):
        assert process.poll() is None
        time.sleep(0.05)
    yield process, found[0]
    process.kill()
    process.wait()
    assert process.stderr is not None
    process.stderr.close()


def descendants_of(process: int) -> list[int]:
    children = told_of(process, f"task/{process}/children").split()
    return [one for child in map(int, children) for one in (child, *descendants_of(child))]


def is_stepping(process: int) -> bool:
    return "probe.so" in told_of(process, "maps")


def told_of(process: int, file: str) -> str:
    """Return what /proc tells of a process, nothing if it has ended."""
    try:
        return Path(f"/proc/{process}/{file}").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return ""


def is_gone(process: int) -> bool:
    status = told_of(process, "status")
    return not status or "State:\tZ" in status


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_the_process_as_well(running, number: signal.Signals) -> None:
    master, child = running
    master.send_signal(number)
    _, said = master.communicate()
    assert master.returncode == 130
    assert "interrupted; nothing was written" in said
    assert is_gone(child)


def test_a_killed_master_leaves_no_process(running) -> None:
    master, child = running
    master.kill()
    master.wait()
    for _ in range(600):
        if is_gone(child):
            return
        time.sleep(0.1)
    raise AssertionError(child)


def test_the_command_tells_of_a_crash_in_one_sentence(
    probe: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "guest.toml").write_text(TOML.replace("isolate = true", "").replace("1e6", "1.0"))
    monkeypatch.chdir(tmp_path)
    arguments = ["run", "guest.toml", "--set", "guest.fail_at=0.5", "--set", f"guest.fail_status={SEGFAULT}"]
    result = CliRunner().invoke(app, [*arguments, "--isolate"])
    assert result.exit_code == 1
    said = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert said == ["error: guest at t = 0.50 s: the FMU crashed in fmi2DoStep (SIGSEGV)"]
    assert not (tmp_path / "runs" / "guest" / "trajectory.csv").exists()
    assert CliRunner().invoke(app, ["run", "guest.toml", "--isolate"]).exit_code == 0
