"""The master with a real FMU: every type, slopes, messages, failures, and nothing left behind."""

from __future__ import annotations

import json
import logging
import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import Component, Connection, Constant, Scenario, SlaveError, Step, System, ramp, simulate, stream
from cosim.errors import FmuFileError, RunError, SystemDefinitionError
from cosim.fmi2.fmu_slave import open_fmu
from cosim.fmi2.model_description import read_description
from cosim.recording.record import allocate_block
from cosim.run.trajectory import open_trajectory

pytestmark = pytest.mark.usefixtures("no_leftovers")


def scenario(probe: Path, *, inputs=None, parameters=None, connections=(), names=("probe",), stop=1.0, step=0.1):
    components = tuple(Component(name, probe, parameters or {}) for name in names)
    return Scenario("test", System(components, connections, inputs or {}), stop_time=stop, step_size=step)


def test_every_type_of_value_reaches_the_fmu_and_the_record(probe: Path) -> None:
    inputs = {"probe.u": Constant(2.0), "probe.n": Step(3, 4, at=0.5), "probe.flag": Step(False, True, at=0.5)}
    result = simulate(scenario(probe, inputs=inputs, parameters={"mode": "fast", "gain": 3, "text": "ü"}))
    assert result["probe.integral"] == pytest.approx(3 * 2.0 * result.time, rel=1e-14)
    assert result["probe.n_next"].dtype == np.int32
    assert result["probe.n_next"].tolist() == [0] + [3 + 5] * 5 + [4 + 5] * 5
    assert result["probe.not_flag"].dtype == np.bool_
    assert result["probe.not_flag"].tolist() == [True] * 6 + [False] * 5
    assert result["probe.u"].tolist() == [2.0] * 11
    assert result.units["probe.integral"] == "rad"


def test_a_ramp_is_passed_with_its_exact_derivative(probe: Path) -> None:
    result = simulate(scenario(probe, inputs={"probe.u": ramp(0.0, 3.0, 0.25, 0.5)}))
    exact = np.interp(result.time, [0.25, 0.75], [0.0, 3.0])
    assert result["probe.u_seen"] == pytest.approx(exact, abs=1e-14)
    assert result["probe.u"] == pytest.approx(exact, abs=1e-14)
    assert result["probe.integral"][-1] == pytest.approx(0.5 * 0.5 * 3.0 + 0.25 * 3.0, rel=1e-14)


def test_without_interpolation_a_ramp_is_held_over_each_step(make_probe: Callable[..., Path]) -> None:
    probe = make_probe(replace={'canInterpolateInputs="true"': ""})
    result = simulate(scenario(probe, inputs={"probe.u": ramp(0.0, 1.0, 0.0, 1.0)}, step=0.25))
    assert result["probe.u_seen"].tolist() == [0.0, 0.0, 0.25, 0.5, 0.75]


def test_a_jump_between_steps_becomes_a_communication_point(probe: Path) -> None:
    result = simulate(scenario(probe, inputs={"probe.u": Step(0.0, 1.0, at=0.33)}))
    assert 0.33 in result.time
    assert result["probe.integral"][-1] == pytest.approx(0.67, rel=1e-13)


def test_with_a_fixed_step_a_jump_waits_and_the_log_says_so(
    make_probe: Callable[..., Path], caplog: pytest.LogCaptureFixture
) -> None:
    probe = make_probe(replace={'canHandleVariableCommunicationStepSize="true"': ""})
    result = simulate(scenario(probe, inputs={"probe.u": Step(0.0, 1.0, at=0.33)}))
    assert result["probe.integral"][-1] == pytest.approx(0.6, rel=1e-13)
    assert "probe.u changes at t = 0.33 s" in caplog.text
    assert "takes effect at t = 0.40 s" in caplog.text


def test_messages_reach_the_logger_of_their_instance(probe: Path, caplog: pytest.LogCaptureFixture) -> None:
    simulate(scenario(probe, names=("first", "second")))
    said = [(record.name, record.levelno, record.getMessage()) for record in caplog.records]
    assert ("cosim.fmi2.first", logging.WARNING, "ready at 1.5") in said
    assert ("cosim.fmi2.second", logging.WARNING, "ready at 1.5") in said


@pytest.mark.parametrize(("status", "name"), [(2, "fmi2Discard"), (3, "fmi2Error"), (4, "fmi2Fatal")])
def test_a_failed_step_becomes_a_sentence_with_the_fmus_own_message(probe: Path, status: int, name: str) -> None:
    with pytest.raises(SlaveError) as caught:
        simulate(scenario(probe, parameters={"fail_at": 0.35, "fail_status": status}))
    message = "the probe gave up at 0.4 s"
    assert str(caught.value) == f"probe at t = 0.40 s: fmi2DoStep returned {name}: {message}"
    assert caught.value.component == "probe"
    assert caught.value.time == pytest.approx(0.4)


def test_a_refused_value_names_the_setter_and_the_time(probe: Path) -> None:
    nan_later = Step(0.0, 1.0, at=0.5)
    object.__setattr__(nan_later, "after", float("nan"))
    with pytest.raises(SystemDefinitionError, match=r"probe\.u is nan rad/s; expected a finite number"):
        simulate(scenario(probe, inputs={"probe.u": nan_later}))


def test_a_failed_instantiation_is_a_sentence(probe: Path) -> None:
    with pytest.raises(RunError, match="refused: fmi2Instantiate failed: not this time, 7"):
        simulate(scenario(probe, names=("refused",)))


def test_an_interrupt_leaves_nothing_behind(probe: Path) -> None:
    def interrupt(part: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(scenario(probe), progress=interrupt)


@pytest.fixture
def slave(probe: Path):
    """A probe at t = 0 whose input u is driven, with room for three rows."""
    description = read_description(probe)
    with open_fmu("probe", probe, description) as slave:
        block = allocate_block(description, ["u"], {}, 3)
        slave.setup(block, {}, 0.0, 1.0)
        slave.enter_initialization()
        slave.exit_initialization()
        block.inputs["Real"].values[1:, 0] = 2.0, 4.0
        yield slave, block.outputs["Real"].values[:, 0]


def test_a_step_from_a_restored_state_repeats_the_same_bits(slave) -> None:
    probe, integral = slave
    found: list[float] = []
    probe.save(0)
    for row in (1, 2, 1):
        probe.write(row)
        probe.step(0.0, 0.1)
        probe.read(row)
        found.append(float(integral[row]))
        probe.restore(0)
    assert found == [0.1 * 2.0, 0.1 * 4.0, 0.1 * 2.0]


def test_states_under_different_numbers_keep_apart(slave) -> None:
    probe, integral = slave
    probe.save(0)
    probe.write(1)
    probe.step(0.0, 0.1)
    probe.save(1)
    probe.step(0.1, 0.1)
    probe.restore(1)
    probe.read(2)
    assert integral[2] == 0.1 * 2.0
    probe.restore(0)
    probe.read(2)
    assert integral[2] == 0.0


def test_failures_that_were_undone_are_not_told_again(make_probe: Callable[..., Path]) -> None:
    path = make_probe()
    description = read_description(path)
    values = {description.by_name["fail_at"]: 0.05}
    with open_fmu("probe", path, description) as probe:
        probe.setup(allocate_block(description, [], values, 1), values, 0.0, 1.0)
        probe.enter_initialization()
        probe.exit_initialization()
        probe.step(0.0, 0.1)
        probe.save(0)
        with pytest.raises(SlaveError, match=r"the probe gave up at 0\.1 s$"):
            probe.step(0.1, 0.1)
        probe.restore(0)
        with pytest.raises(SlaveError, match=r"fmi2Discard: the probe gave up at 0\.2 s$"):
            probe.step(0.2, 0.1)


def test_two_components_of_one_fmu_keep_apart(probe: Path) -> None:
    connections = (Connection("first.u_seen", "second.u"),)
    result = simulate(
        scenario(probe, names=("first", "second"), connections=connections, inputs={"first.u": Constant(1.0)})
    )
    assert result["first.integral"][-1] == pytest.approx(1.0)
    assert result["second.u_seen"].tolist() == [0.0] + [0.0] + [1.0] * 9


def test_once_per_process_is_respected(make_probe: Callable[..., Path]) -> None:
    once = {'canInterpolateInputs="true"': 'canBeInstantiatedOnlyOncePerProcess="true"'}
    with pytest.raises(SystemDefinitionError, match=r"first and second are both probe\.fmu, which allows one"):
        simulate(scenario(make_probe(replace=once), names=("first", "second")))


def test_a_file_that_is_not_an_fmu_is_refused_by_name(tmp_path: Path) -> None:
    text = tmp_path / "text.fmu"
    text.write_text("not a zip archive")
    with pytest.raises(FmuFileError, match=r"text\.fmu is not an FMU: it is not a zip archive"):
        read_description(text)
    empty = tmp_path / "empty.fmu"
    with zipfile.ZipFile(empty, "w"):
        pass
    with pytest.raises(FmuFileError, match=r"empty\.fmu is not an FMU: there is no modelDescription\.xml"):
        read_description(empty)
    with pytest.raises(FmuFileError, match=r"absent\.fmu: there is no such file"):
        read_description(tmp_path / "absent.fmu")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('fmiVersion="2.0"', 'fmiVersion="3.0"', "FMI version is 3.0; expected 2.0"),
        ('fmiVersion="2.0"', 'fmiVersion="1.0"', "FMI version is 1.0; expected 2.0"),
        ("CoSimulation", "ModelExchange", "(cannot be used|not valid|model exchange only)"),
        ('causality="parameter"', 'causality="nonsense"', "modelDescription.xml is not valid"),
        ("</fmiModelDescription>", "", "modelDescription.xml is not XML"),
    ],
)
def test_an_fmu_of_another_kind_is_refused(make_probe: Callable[..., Path], old: str, new: str, message: str) -> None:
    with pytest.raises(FmuFileError, match=message):
        read_description(make_probe(replace={old: new}))


def test_a_model_exchange_fmu_is_refused_as_such(make_probe: Callable[..., Path]) -> None:
    capabilities = ' canHandleVariableCommunicationStepSize="true" canInterpolateInputs="true"'
    path = make_probe(replace={"CoSimulation": "ModelExchange", capabilities: ""})
    with pytest.raises(FmuFileError, match="for model exchange only; expected one for co-simulation"):
        read_description(path)


def test_an_fmu_for_other_platforms_is_refused_with_those_it_has(make_probe: Callable[..., Path]) -> None:
    path = make_probe(folder="riscv64-linux")
    with pytest.raises(FmuFileError, match="it has binaries for riscv64-linux"):
        simulate(scenario(path))


def test_a_broken_library_leaves_the_working_directory_alone(make_probe: Callable[..., Path], tmp_path: Path) -> None:
    good, broken = make_probe(), tmp_path / "broken.fmu"
    with zipfile.ZipFile(good) as source, zipfile.ZipFile(broken, "w") as target:
        for name in source.namelist():
            target.writestr(name, source.read(name) if name.endswith(".xml") else b"nonsense")
    before = os.getcwd()
    with pytest.raises(FmuFileError, match=r"broken\.fmu: .* is no library; expected one for"):
        simulate(scenario(broken))
    assert os.getcwd() == before


def test_parameters_survive_an_experiment_whose_set_up_resets_them(probe: Path) -> None:
    result = simulate(
        scenario(probe, names=("resetting",), parameters={"gain": 3.0}, inputs={"resetting.u": Constant(2.0)})
    )
    assert result["resetting.integral"][-1] == pytest.approx(3.0 * 2.0, rel=1e-14)


@pytest.mark.parametrize("isolate", [False, True])
def test_a_parameter_that_the_fmu_does_not_keep_is_named(
    probe: Path, caplog: pytest.LogCaptureFixture, isolate: bool
) -> None:
    given = {"gain": 3.0, "text": "ü", "mode": "fast"}
    record = simulate(scenario(probe, names=("forgetful", "probe"), parameters=given), isolate=isolate).record
    said = [record.getMessage() for record in caplog.records if "after initialisation" in record.getMessage()]
    assert said == ["gain was set to 3.0, but the FMU has 1.0 after initialisation"]
    asked, kept = record["components"]["forgetful"], record["components"]["probe"]
    assert (asked["parameters"]["gain"], asked["asked"]) == (1.0, {"gain": 3.0})
    assert (asked["parameters"]["mode"], kept["parameters"]["gain"]) == ("fast", 3.0)
    assert "asked" not in kept


def test_a_streamed_run_tells_what_was_not_kept_as_well(probe: Path, tmp_path: Path) -> None:
    given = scenario(probe, names=("forgetful",), parameters={"gain": 3.0, "mode": "fast"})
    record = stream(given, tmp_path / "out").record
    told = open_trajectory(tmp_path / "out").attrs
    for components in (record["components"], json.loads(told["components"])):
        found = components["forgetful"]
        assert (found["parameters"]["gain"], found["asked"]) == (1.0, {"gain": 3.0})


@pytest.mark.parametrize("start", ['start="7"', ""])
@pytest.mark.parametrize("order", [("offering", "dividing"), ("dividing", "offering")])
@pytest.mark.parametrize("algorithm", ["jacobi", "implicit"])
def test_a_connected_input_is_its_start_value_until_its_source_is_known(
    make_probe: Callable[..., Path], algorithm: str, order: tuple[str, ...], start: str
) -> None:
    old = 'name="u" valueReference="0" causality="input"><Real start="0"'
    probe = make_probe(replace={old: old.replace('start="0"', start)})
    inputs = {"offering.u": Constant(5.0)}
    connected = scenario(probe, names=order, inputs=inputs, connections=(Connection("offering.u_seen", "dividing.u"),))
    result = simulate(connected, algorithm=algorithm)
    assert result["dividing.u"].tolist() == [5.0] * 11


@pytest.mark.parametrize("choices", [{}, {"algorithm": "gauss-seidel"}, {"algorithm": "implicit"}, {"tolerance": 1e-4}])
@pytest.mark.parametrize("isolate", [False, True])
@pytest.mark.parametrize(("stop", "step"), [(100.0, 0.01), (1.0, 0.1), (5.0, 0.05), (0.3, 0.1)])
def test_an_fmu_that_is_strict_about_its_stop_time_reaches_it(
    probe: Path, choices: dict[str, Any], isolate: bool, stop: float, step: float
) -> None:
    inputs = {"strict.u": Constant(1.0), "strict.v": Constant(0.0)}
    run = scenario(probe, names=("strict",), inputs=inputs, stop=stop, step=step)
    result = simulate(run, isolate=isolate, **choices)
    assert result.time[-1] == pytest.approx(stop, rel=1e-15)
    assert result["strict.integral"][-1] == pytest.approx(stop, rel=1e-12)
