"""The scenarios of the cures: each engaged in full stick-slip through a Boolean input, and what does not cure."""

from __future__ import annotations

import numpy as np
import pytest

from cosim import Result, load_scenario, simulate

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
