"""The damped plant takes the place of the neutral one in any scenario."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cosim import Scenario, load_scenario, simulate
from cosim.drilling.oscillation import measure
from cosim.scenario.file import scenario_names


def with_damped_plant(scenario: Scenario, **parameters: float) -> Scenario:
    """Return a scenario with the one plant in place of the other."""
    components = tuple(
        replace(component, fmu="DrillstringDistributed", parameters={**component.parameters, **parameters})
        if component.fmu == "DrillstringNeutral"
        else component
        for component in scenario.system.components
    )
    return replace(scenario, system=replace(scenario.system, components=components))


def is_neutral(name: str) -> bool:
    return any(component.fmu == "DrillstringNeutral" for component in load_scenario(name).system.components)


NEUTRAL = [name for name in scenario_names() if is_neutral(name)]


@pytest.mark.parametrize("name", NEUTRAL)
def test_without_damping_every_scenario_has_the_same_bits(name):
    scenario = load_scenario(name)
    for variant in [variant.name for variant in scenario.variants] or [None]:
        neutral = simulate(scenario, variant=variant, stop_time=12.0)
        # stations would divide some strings into more blocks
        damped = simulate(with_damped_plant(scenario, stations=0), variant=variant, stop_time=12.0)
        for signal in ("bit_speed", "top_speed", "bit_torque", "top_torque", "energy", "slip_count"):
            assert damped[f"plant.{signal}"].tobytes() == neutral[f"plant.{signal}"].tobytes(), signal


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NEUTRAL if name != "dissipative-law"])
def test_with_damping_every_scenario_runs_and_turns_slower(name):
    scenario = load_scenario(name)
    for variant in [variant.name for variant in scenario.variants] or [None]:
        neutral = simulate(scenario, variant=variant)
        damped = simulate(with_damped_plant(scenario, beta=0.05), variant=variant)
        assert 0.0 < damped["plant.bit_angle"][-1] < neutral["plant.bit_angle"][-1]


def test_stations_change_the_cycle_of_figure_2_by_no_more_than_the_grid():
    neutral = measure(simulate(load_scenario("stick-slip")))
    damped = measure(simulate(with_damped_plant(load_scenario("stick-slip"), stations=9)))
    assert neutral is not None
    assert damped is not None
    assert damped.period == pytest.approx(neutral.period, abs=1e-9)
    assert damped.peak == pytest.approx(neutral.peak, abs=1e-7)


def test_damping_along_the_string_makes_the_cycle_shorter_and_lower():
    scenario = load_scenario("string-damping")
    found = [measure(simulate(scenario, variant=variant.name)) for variant in scenario.variants]
    assert len(found) == 5
    for what in ("period", "peak", "mean_speed"):
        assert (np.diff([getattr(measures, what) for measures in found]) < 0.0).all(), what
