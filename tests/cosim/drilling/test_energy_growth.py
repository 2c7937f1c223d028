"""Proposition 1 along runs with law (9): all growth of the energy has a cause, and where the law is obeyed none is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cosim import Component, Constant, InputError, Scenario, System, Table, load_scenario, simulate
from cosim.drilling.energy_growth import EnergyGrowth, deviation_growth, energy_growth, incident_wave
from cosim.recording.result import Result

pytestmark = pytest.mark.slow

ALGORITHMS = ("jacobi", "gauss-seidel", "implicit")
FORMS = ("printed", "tracking")
ROUNDING = 1e-9
"""Of the energy at its greatest: what 1e4 steps of accumulated work leave."""
OFF_BOTTOM = {"program.WOB_initial": 0.0, "program.WOB_final": 0.0, "plant.initial_speed": 30.0}
"""A string that turns freely: the waves it sends up, 15 rad/s, leave the loop a solution until they return."""


@cache
def run(form: str, algorithm: str, stop_time: float = 3.0, step_size: float = 1e-3, **values: float) -> Result:
    overrides = {name.replace("__", "."): value for name, value in values.items()}
    return simulate(
        load_scenario("dissipative-law"),
        variant=form,
        algorithm=algorithm,
        on_failure="explicit",
        stop_time=stop_time,
        step_size=step_size,
        overrides=overrides,
    )


@cache
def damped(form: str, algorithm: str, beta: float = 0.05) -> Result:
    scenario = load_scenario("dissipative-law")
    parts = tuple(
        replace(part, fmu="DrillstringDistributed", parameters={**part.parameters, "beta": beta})
        if part.name == "plant"
        else part
        for part in scenario.system.components
    )
    scenario = replace(scenario, system=replace(scenario.system, components=parts))
    return simulate(scenario, variant=form, algorithm=algorithm, on_failure="explicit", stop_time=2.0)


def off_bottom(algorithm: str, step_size: float = 1e-3) -> Result:
    return run("printed", algorithm, 0.7, step_size, **{name.replace(".", "__"): v for name, v in OFF_BOTTOM.items()})


def known(growth: EnergyGrowth) -> dict[str, float]:
    """Return the growth of each cause that made any."""
    return {name: share.growth for name, share in growth.shares().items() if share.steps}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("form", FORMS)
def test_causes_share_all_growth_and_nothing_else(form: str, algorithm: str) -> None:
    result = run(form, algorithm)
    found, energy = energy_growth(result), result["plant.energy"]
    gained = np.diff(energy)
    scale = energy.max()
    assert sum(share.growth for share in found.shares().values()) == pytest.approx(gained[gained > 0].sum(), rel=1e-9)
    assert sum(share.steps for share in found.shares().values()) <= (gained > 0).sum()
    assert found.change.sum() == pytest.approx(energy[-1] - energy[0], abs=ROUNDING * scale)
    worked, lost = np.diff(result["plant.work_in"]), np.diff(result["plant.bit_loss"] + result["plant.folded_energy"])
    assert np.abs(found.lawful[1:] + found.excess[1:] - worked + lost).max() <= ROUNDING * scale
    assert found.growth > 1e4


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_printed_law_would_never_let_the_energy_grow_at_the_motion_there_was(algorithm: str) -> None:
    found = energy_growth(run("printed", algorithm))
    assert found.lawful.max() <= 1e-12 * run("printed", algorithm)["plant.energy"].max()
    assert "law" not in known(found)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("form", FORMS)
def test_string_that_is_damped_along_its_length_is_audited_the_same_way(form: str, algorithm: str) -> None:
    result = damped(form, algorithm)
    found, gained = energy_growth(result), np.diff(result["plant.energy"])
    assert result["plant.string_loss"][-1] > 100.0
    assert found.growth == pytest.approx(gained[gained > 0].sum(), rel=1e-9)
    assert (found.lawful.max() > 0.0) == (form == "tracking")
    assert ("law" in known(found)) == (form == "tracking")


def test_damped_string_has_no_rotation_for_its_deviations() -> None:
    with pytest.raises(InputError, match="damped along its length"):
        deviation_growth(damped("tracking", "gauss-seidel"))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_tracking_law_asks_for_growth_itself(algorithm: str) -> None:
    """It feeds a string that is to turn: Proposition 1 is not about it. Sampling makes next to nothing."""
    found = energy_growth(run("tracking", algorithm))
    assert known(found)["law"] > 0.999 * found.growth
    assert found.solvable.all()


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_energy_of_deviations_grows_by_falling_friction_only(algorithm: str) -> None:
    """It starts as that of the whole wanted rotation, I_B r^2 / 2 + I L r^2 / 2 + T^2 L / (2 GJ), and all is lost."""
    result = run("tracking", algorithm, 40.0)
    found = deviation_growth(result)
    torque, rock = result["law.bit_torque_ref"][0], 97347.0 * 0.155575
    at_start = 0.5 * (89.0 + 0.095 * 1172.0) * 10.0**2 + 0.5 * torque**2 * 1172.0 / (79.3e9 * 1.19e-5)
    assert found.change.sum() == pytest.approx(-at_start, rel=2e-3)
    assert known(found)["law"] > 0.99999 * found.growth > 0.01 * at_start
    speed = result["plant.bit_speed"]
    dry = rock * (0.5 + 0.3 * np.exp(-0.9 * speed))
    fed = (dry - rock * (0.5 + 0.3 * np.exp(-9.0))) * (speed - 10.0)
    grows = np.flatnonzero((found.change > 1e-3) & ~result["plant.bit_stuck"])
    assert grows.size > 100
    assert np.minimum(fed[grows], fed[grows - 1]).max() < 0.0


def test_excess_of_the_tracking_law_fades_with_the_step_and_that_of_the_printed_law_does_not() -> None:
    """The one is sampled, the other has nothing to be a sample of."""
    excess = {
        (form, size): np.abs(energy_growth(run(form, "gauss-seidel", 4.0, size)).excess).sum()
        for form in FORMS
        for size in (2e-3, 1e-3, 5e-4)
    }
    for coarse, fine in ((2e-3, 1e-3), (1e-3, 5e-4)):
        assert excess["tracking", fine] == pytest.approx(0.5 * excess["tracking", coarse], rel=0.1)
        assert excess["printed", fine] > 0.8 * excess["printed", coarse]


def test_energy_never_grows_where_the_loop_has_a_solution_and_is_closed() -> None:
    """Proposition 1 as it stands, from a start whose waves allow it."""
    found = energy_growth(off_bottom("implicit"))
    assert found.solvable.all()
    assert known(found) == {}
    assert found.change[1:].max() < 0.0
    sampled = energy_growth(off_bottom("jacobi"))
    assert np.abs(found.excess).sum() < 1e-3 * np.abs(sampled.excess).sum()


def test_sampled_law_that_has_a_solution_errs_in_proportion_to_the_step() -> None:
    excess = [np.abs(energy_growth(off_bottom("jacobi", size)).excess).sum() for size in (2e-3, 1e-3, 5e-4)]
    assert excess[0] > 1.0
    assert excess[1:] == pytest.approx([0.5 * excess[0], 0.25 * excess[0]], rel=0.1)


@pytest.mark.parametrize("along", [run, damped], ids=["undamped", "damped"])
def test_iteration_closes_the_loop_only_where_its_discriminant_says_so(along: Callable[[str, str], Result]) -> None:
    result = along("printed", "implicit")
    asked, driven = result["law.Omega"], result["plant.Omega"]
    closed = np.abs(asked - driven)[1:] <= 1e-9 * np.maximum(np.abs(asked), 10.0)[1:]
    assert np.count_nonzero(~closed) == result.record["unsolved"]["steps"]
    solvable = energy_growth(result).solvable[1:]
    assert closed.any()
    assert solvable[closed].all()
    assert solvable.mean() < 0.3


def test_drive_that_is_always_at_its_limit_is_not_blamed_on_sampling() -> None:
    """A limit of half a rad/s is below whatever the law asks for, but where the loop happens to have a solution."""
    result = run("printed", "gauss-seidel", 4.0, law__Omega_max=0.5)
    found = energy_growth(result)
    assert (np.abs(result["plant.Omega"][1:]) == 0.5).mean() > 0.99
    causes = known(found)
    assert sum(causes[name] for name in causes if "sampling" not in name) > 0.99 * found.growth > 0.0


def test_law_that_asks_for_a_constant_speed_makes_no_excess() -> None:
    """With c_1 = 0 and c_b = 0 the tracking form is r + T_ref / c_a: sampled or not, it is obeyed at every instant."""
    result = run("tracking", "jacobi", 8.0, 1e-2, law__c_1=0.0, law__c_b=0.0)
    assert np.ptp(result["plant.Omega"][1:]) == 0.0
    found = energy_growth(result)
    assert np.abs(found.excess).max() <= ROUNDING * result["plant.energy"].max()
    assert set(known(found)) <= {"law"}


@cache
def replayed(stop_time: float, per_step: int) -> tuple[Result, Result]:
    """Give the drive speeds of a run to the plant alone, with communication points close together."""
    coarse = run("printed", "gauss-seidel", stop_time)
    held, time = coarse["plant.Omega"], coarse.time
    points = np.repeat(time[1:-1], 2)
    times = np.concatenate([time[:1], points, time[-1:]])
    values = np.repeat(held[1:], 2)
    system = System(
        (Component("plant", "DrillstringNeutral"),),
        inputs={"plant.Omega": Table(times, values), "plant.WOB": Constant(97347.0)},
    )
    fine = simulate(Scenario("replay", system, stop_time, 1e-3 / per_step))
    assert fine["plant.energy"][::per_step] == pytest.approx(coarse["plant.energy"], rel=1e-6, abs=1e-6)
    return coarse, fine


def test_excess_is_the_work_of_the_difference_between_drive_and_law() -> None:
    """The integral of c_a (Omega - Omega*) ydot, with paper (9) put out at every tenth of a step of a run replayed.

    Until the first waves return, 0.74 s, speeds go without jumps within a step.
    """
    per_step = 10
    coarse, fine = replayed(0.7, per_step)
    gap = 1e-3 / per_step
    top, bit = fine["plant.top_speed"], fine["plant.bit_speed"]
    r, c_1, c_2, share = 10.0, 0.3, 2.0, 0.03 / 2000.0
    expected = np.zeros(coarse.time.size)
    for step in range(1, coarse.time.size):
        rows = slice((step - 1) * per_step + 1, step * per_step + 1)
        # a value is the limit from the left: the one at the beginning of the step is not of this step
        y, v = top[rows], bit[rows]
        lawful = c_1 * y**2 + 2 * np.sqrt(share * (1 - c_1)) * v * y + 2 * np.sqrt(c_2 * (1 - c_1)) * r * y
        lawful -= c_2 * r**2 + 2 * np.sqrt(c_2 * share) * v * r
        rate = 2000.0 * (coarse["plant.Omega"][step] * y - lawful)
        values = np.concatenate([[2.0 * rate[0] - rate[1]], rate])
        expected[step] = gap * float(np.sum(values[1:] + values[:-1])) / 2.0
    found = energy_growth(coarse).excess
    assert found[1:] == pytest.approx(expected[1:], rel=1e-3, abs=1e-3 * np.abs(expected).max())


def test_wave_that_arrives_is_the_one_the_bit_sent() -> None:
    """From rest nothing arrives for a travel time; a held drive of 10 rad/s then meets its own echo."""
    result = simulate(load_scenario("stick-slip"), stop_time=2.0, step_size=1e-3)
    wave, travel = incident_wave(result), 0.371859893
    before = result.time < 2 * travel - 1e-9
    assert np.abs(wave[before]).max() < 1e-9
    after = (result.time > 2 * travel + 1e-3) & (result.time < 4 * travel - 1e-3)
    # the bit is stuck: the wave 10 c_a / Lambda comes back with its sign changed
    assert wave[after] == pytest.approx(np.full(after.sum(), -10 * 2000 / 2299.413844), rel=1e-9)


def test_runs_that_do_not_tell_enough_are_refused() -> None:
    result = run("tracking", "gauss-seidel")
    with pytest.raises(InputError, match="no parameters of 'drive'"):
        energy_growth(result, law="drive")
    with pytest.raises(InputError, match="no parameters of 'plant'"):
        energy_growth(Result(result.time, result.columns, result.units))
    with pytest.raises(InputError, match="of the printed form"):
        deviation_growth(run("printed", "gauss-seidel"))
    changing = {**result.columns, "law.bit_speed_ref": result["law.bit_speed_ref"] + result.time}
    with pytest.raises(InputError, match=r"law\.bit_speed_ref changes"):
        deviation_growth(Result(result.time, changing, result.units, result.record))
    other = {**result.columns, "plant.Omega": result["plant.Omega"] + 1.0}
    with pytest.raises(InputError, match=r"plant\.Omega is not law\.Omega"):
        energy_growth(Result(result.time, other, result.units, result.record))
