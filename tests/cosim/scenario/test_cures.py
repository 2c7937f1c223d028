"""The scenarios of the cures: each engaged in full stick-slip through a Boolean input, and what does not cure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cosim import Result, Step, load_scenario, simulate

ENGAGED = 60.0
"""When `enabled` becomes true [s]."""


def severity(result: Result) -> float:
    """Return (max - min) / (2 mean) of the bit speed over the last 20 s."""
    end = result["plant.bit_speed"][result.time >= result.time[-1] - 20.0]
    return float((end.max() - end.min()) / (2.0 * end.mean()))


def last_stuck(result: Result) -> float:
    """Return when the bit was stuck last [s]; 0 if it never was."""
    stuck = np.diff(result["plant.stuck_time"]) > 1e-9
    return float(result.time[1:][stuck][-1]) if stuck.any() else 0.0


@pytest.mark.parametrize(
    ("name", "variant", "within"),
    [
        ("soft-torque", "soft-torque", 20.0),
        ("soft-torque", "impedance-matching", 30.0),
        ("top-absorber", None, 10.0),
        ("speed-pid", "light-rotor", 10.0),
    ],
)
def test_a_cure_engaged_in_full_cycle_frees_the_string(name: str, variant: str | None, within: float) -> None:
    result = simulate(load_scenario(name), variant=variant)
    assert ENGAGED < last_stuck(result) <= ENGAGED + within
    assert severity(result) <= 0.05


@pytest.mark.parametrize(
    ("name", "variant"), [("soft-torque", "too-stiff"), ("soft-torque", "drive-too-slow"), ("speed-pid", "heavy-rotor")]
)
def test_what_is_too_stiff_too_slow_or_too_heavy_does_not(name: str, variant: str) -> None:
    result = simulate(load_scenario(name), variant=variant)
    assert last_stuck(result) > 135.0
    assert severity(result) > 1.0


def test_weight_put_on_in_ten_seconds_stops_the_bit_of_a_soft_drive_alone() -> None:
    stuck = {
        variant: float(simulate(load_scenario("loading"), variant=variant)["plant.stuck_time"][-1])
        for variant in ("soft_10s", "stiff_10s", "soft_20s")
    }
    assert stuck["soft_10s"] == pytest.approx(3.89, abs=0.02)
    assert (stuck["stiff_10s"], stuck["soft_20s"]) == (0.0, 0.0)


def test_stick_slip_costs_depth() -> None:
    depths: dict[str, float] = {}
    for variant in ("soft-torque", "stiff-drive"):
        result = simulate(load_scenario("autodriller"), variant=variant)
        begin = int(np.searchsorted(result.time, 60.0))
        depths[variant] = float(result["driller.depth"][-1] - result["driller.depth"][begin]) / 300.0 * 3600.0
    assert depths["soft-torque"] == pytest.approx(6.71, rel=0.01)
    assert depths["stiff-drive"] == pytest.approx(5.87, rel=0.02)


def test_thicker_mud_ends_stick_slip_for_good() -> None:
    """The cycle ends at 132 N m s/rad on the way up; on the way down the string goes on in the other of its two states.

    6.205186764 rad/s is the equilibrium of the string with its own damping, which is stable at 10 rad/s.
    """
    result = simulate(load_scenario("mud"))
    ended = int(np.searchsorted(result.time, last_stuck(result)))
    assert result["plant.c_b"][ended] == pytest.approx(132.1, abs=0.5)
    assert result["plant.bit_speed"][-1] == pytest.approx(6.205186764, abs=1e-6)
    assert result["plant.folded_energy"][-1] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("damping", "frees"), [(120.0, False), (130.0, True)])
def test_a_damping_tool_ends_stick_slip_if_it_is_strong_enough(damping: float, frees: bool) -> None:
    scenario = load_scenario("downhole-tool")
    inputs = {**scenario.system.inputs, "plant.c_b": Step(0.03, damping, ENGAGED)}
    system = replace(scenario.system, inputs=inputs)
    result = simulate(replace(scenario, system=system, signals=()), stop_time=200.0)
    assert (last_stuck(result) < ENGAGED + 5.0) is frees
    assert (severity(result) < 1e-3) is frees


def test_a_damping_tool_is_needed_no_longer_than_stick_slip_lasts() -> None:
    """While it damps it takes 4.4 kW and 0.38 rad/s; switched off, it leaves the string as an ordinary one turns."""
    result = simulate(load_scenario("downhole-tool"))
    assert ENGAGED < last_stuck(result) < ENGAGED + 5.0
    damped = float(result["plant.bit_speed"][int(np.searchsorted(result.time, 199.0))])
    assert damped == pytest.approx(5.8233, abs=1e-3)
    assert 130.0 * damped**2 == pytest.approx(4409.0, abs=2.0)
    assert result["plant.bit_speed"][-1] == pytest.approx(6.205186764, abs=1e-6)


def test_a_harder_formation_starts_stick_slip_that_a_softer_one_does_not_end() -> None:
    """Under a soft drive the bit turns again 11 s after it is met, at 5.242 rad/s, and then at 6.205."""
    soft, ordinary = (simulate(load_scenario("formation"), variant=name) for name in ("soft-torque", "ordinary-drive"))
    assert last_stuck(ordinary) > 195.0
    assert 65.0 < last_stuck(soft) < 75.0
    hard = int(np.searchsorted(soft.time, 119.0))
    assert soft["plant.bit_speed"][[hard, -1]] == pytest.approx([5.2418, 6.2052], abs=2e-4)


def test_a_string_starts_up_without_stick_slip_by_a_soft_drive_or_by_weight_that_waits() -> None:
    found = {name: simulate(load_scenario("start-up"), variant=name) for name in ("soft-torque", "weight-later")}
    assert last_stuck(found["soft-torque"]) < 20.0
    assert severity(found["soft-torque"]) < 0.05
    assert last_stuck(found["weight-later"]) < 1.0, "but for when it sets out"
    assert severity(found["weight-later"]) < 1e-3
    ordinary = simulate(load_scenario("start-up"), variant="ordinary-drive")
    assert last_stuck(ordinary) > 135.0
    assert severity(ordinary) > 1.0


@pytest.mark.parametrize(("name", "variant"), [("supervision", "mud-pulse"), ("top-supervision", None)])
def test_a_supervisor_raises_the_speed_until_the_string_is_free(name: str, variant: str | None) -> None:
    result = simulate(load_scenario(name), variant=variant)
    raised = result.time[1:][np.diff(result["supervisor.speed_ref"]) > 0.0]
    assert raised == pytest.approx([30.0, 60.0, 90.0, 120.0, 150.0], abs=0.011)
    assert 120.0 < last_stuck(result) < 150.0
    assert severity(result) < 1e-3
    assert result["plant.bit_speed"][-1] == pytest.approx(11.2135, abs=1e-3)


def test_frames_that_are_lost_cost_a_supervisor_time() -> None:
    """Half of them lost, every other decision finds nothing to go by; after 400 s the string still sticks."""
    result = simulate(load_scenario("supervision"), variant="frames-lost")
    assert result["supervisor.speed_ref"][-1] == 16.0
    assert last_stuck(result) > 390.0
