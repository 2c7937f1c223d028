"""The FMUs in fmpy: its own simulation of one FMU, and a loop of a few lines for several.

Numbers of the limit cycle come from a method-of-steps solution good to 1e-9.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from ctypes import c_double, c_int, c_uint
from dataclasses import replace
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

from cosim import load_scenario, simulate
from cosim.recording.result import Result
from cosim.system.signals import Signal, Step, Table
from tests.importers.loop import differences, given, multiples, run
from tests.importers.systems import LOOP, NATIVE, OPEN_START, assert_same_bits, ordered, our_run, system_of

pytestmark = pytest.mark.slow

PLANT = str(NATIVE / "DrillstringNeutral.fmu")
DESCRIPTION = fmpy.read_model_description(PLANT)
FINE = 1.0 / 128
"""A step [s] whose multiples are exact, so that every way to count them gives the same times."""
OUTPUTS = ("bit_speed", "top_speed", "bit_torque", "energy", "slip_count", "stuck_time", "last_release_time")


def columns(recorded: np.ndarray) -> dict[str, np.ndarray]:
    return {f"plant.{name}": np.ascontiguousarray(recorded[name]) for name in OUTPUTS}


def ours_with(name: str, signal: Signal, step_size: float, stop_time: float) -> Result:
    """Run the plant by our master with one input driven by a signal."""
    scenario = load_scenario("stick-slip")
    system = replace(scenario.system, inputs={**scenario.system.inputs, f"plant.{name}": signal})
    return simulate(replace(scenario, system=system), step_size=step_size, stop_time=stop_time)


def test_the_plant_alone_with_nothing_set_is_fig_2() -> None:
    found = fmpy.simulate_fmu(PLANT, stop_time=100.0, output_interval=0.01, output=[*OUTPUTS, "last_stop_time"])
    release, stop = found["last_release_time"], found["last_stop_time"]
    slips = {k: release[found["slip_count"] == k][0] for k in range(1, 20)}
    stops = {k: stop[(found["slip_count"] == k) & (stop > slips[k])][0] for k in range(1, 20)}
    assert slips[1] == pytest.approx(2.603019251, abs=1e-8)
    assert stops[1] == pytest.approx(4.226441632, abs=1e-8)
    assert (slips[2], stops[2]) == pytest.approx((5.577898395, 5.607609331), abs=1e-8)
    periods = np.diff(np.unique(stop)[-6:])
    assert periods == pytest.approx(3.2256227, abs=1e-6)
    assert found["bit_speed"][found["time"] > 80.0].max() == pytest.approx(18.7605, abs=2e-3)


def test_simulate_fmu_repeats_our_master_at_the_times_it_passes() -> None:
    found = fmpy.simulate_fmu(PLANT, stop_time=20.0, output_interval=0.01, output=OUTPUTS)
    assert_same_bits(columns(found), run(system_of("stick-slip", None), differences(0.01, 2000), given({})))


@pytest.mark.parametrize(
    ("scenario", "start_values"), [("higher-speed", {"Omega": 20.0}), ("lower-wob", {"WOB": 31649.0})]
)
def test_start_values_of_inputs_are_those_of_the_scenarios(scenario: str, start_values: dict[str, float]) -> None:
    found = fmpy.simulate_fmu(
        PLANT, stop_time=1280 * FINE, output_interval=FINE, output=OUTPUTS, start_values=start_values
    )
    assert_same_bits(columns(found), our_run(scenario, None, FINE, 1280))


def test_an_input_signal_that_jumps_repeats_our_master() -> None:
    signal = np.array([(0.0, 10.0), (3.0, 10.0), (3.0, 16.0), (8.0, 16.0)], dtype=[("time", "f8"), ("Omega", "f8")])
    found = fmpy.simulate_fmu(PLANT, stop_time=8.0, output_interval=FINE, input=signal, output=OUTPUTS)
    assert_same_bits(columns(found), ours_with("Omega", Step(10.0, 16.0, 3.0), FINE, 8.0))


@pytest.fixture
def plant() -> Iterator[FMU2Slave]:
    """An instance of the plant made by fmpy, not initialised."""
    folder = fmpy.extract(PLANT)
    slave = fmpy.instantiate_fmu(folder, DESCRIPTION, fmi_type="CoSimulation")
    yield slave
    slave.freeInstance()
    shutil.rmtree(folder)


def test_an_input_with_derivatives_is_an_exact_ramp(plant: FMU2Slave) -> None:
    number = {variable.name: variable.valueReference for variable in DESCRIPTION.modelVariables}
    reference, order = (c_uint * 1)(number["Omega"]), (c_int * 1)(1)
    plant.setupExperiment(startTime=0.0)
    plant.enterInitializationMode()
    plant.setReal([number["Omega"]], [0.0])
    plant.exitInitializationMode()
    rows = [plant.getReal([number["bit_speed"], number["top_speed"]])]
    for step in range(16):
        begin = 0.5 * step
        plant.setReal([number["Omega"]], [min(2.0 * begin, 8.0)])
        slope = (c_double * 1)(2.0 if begin < 4.0 else 0.0)
        plant.fmi2SetRealInputDerivatives(plant.component, reference, 1, order, slope)
        plant.doStep(begin, 0.5)
        rows.append(plant.getReal([number["bit_speed"], number["top_speed"]]))
    ours = ours_with("Omega", Table((0.0, 4.0), (0.0, 8.0)), 0.5, 8.0)
    found = dict(zip(("plant.bit_speed", "plant.top_speed"), np.array(rows).T, strict=True))
    assert_same_bits(found, ours)


def test_a_state_saved_by_fmpy_goes_on_with_the_same_bits(plant: FMU2Slave) -> None:
    half, whole = 640 * FINE, 1280 * FINE

    def simulated(**options: Any) -> dict[str, np.ndarray]:
        return columns(
            fmpy.simulate_fmu(
                PLANT, model_description=DESCRIPTION, fmu_instance=plant, output_interval=FINE, output=OUTPUTS,
                terminate=False, set_stop_time=False, **options,
            )
        )  # fmt: skip

    simulated(stop_time=half)
    state = plant.getFMUState()
    kept = plant.serializeFMUState(state)
    plant.freeFMUState(state)
    first = simulated(start_time=half, stop_time=whole, initialize=False)
    plant.reset()
    second = simulated(start_time=half, stop_time=whole, fmu_state=kept)
    ours = our_run("stick-slip", None, FINE, 1280)
    for found in (first, second):
        assert_same_bits(found, {name: ours[name][640:] for name in found})


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(("scenario", "variant"), [*OPEN_START, *LOOP])
def test_a_loop_in_fmpy_repeats_our_master(scenario: str, variant: str | None, algorithm: str) -> None:
    ours = our_run(scenario, variant, 0.001, 5000, algorithm)
    start = {name: values[0] for name, values in ours.columns.items()}
    system = ordered(system_of(scenario, variant), ours.record["order"])
    found = run(system, multiples(0.001, 5000), given(start), sequential=algorithm == "gauss-seidel")
    assert_same_bits(found, ours)
