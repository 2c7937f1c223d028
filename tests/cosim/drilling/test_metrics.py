"""Measures against a motion whose every measure is known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cosim.drilling.oscillation import measure
from tests.cosim.motion import Slip, cycle, record

PERIOD = 3.2256227
LONG = Slip(0.7, 2.3, 18.76)
SHORT = Slip(2.71, 2.75, 0.4)
MEAN = 2.0 / math.pi * (1.6 * 18.76) / PERIOD
MEAN_OF_BOTH = 2.0 / math.pi * (1.6 * 18.76 + 0.04 * 0.4) / PERIOD

STEPS = [0.001, 0.0137, 0.1, 0.37, 0.9]


def times(step: float, stop: float = 50.0) -> np.ndarray:
    return np.arange(round(stop / step) + 1) * step


@pytest.mark.parametrize("step", STEPS)
def test_measures_do_not_depend_on_the_communication_step(step: float) -> None:
    found = measure(record(cycle(PERIOD, [LONG], 20), times(step)))
    assert found is not None
    assert found.period == pytest.approx(PERIOD, rel=1e-12)
    assert found.stops_per_period == 1
    assert found.peak == pytest.approx(18.76, rel=1e-12)
    assert found.minimum == 0.0
    assert found.stuck_fraction == pytest.approx(1.0 - 1.6 / PERIOD, rel=1e-10)
    assert found.mean_speed == pytest.approx(MEAN, rel=1e-10)
    assert found.ssi == pytest.approx(18.76 / (2.0 * MEAN), rel=1e-10)
    assert "6 periods of 1 stop, stop to stop" in found.window


@pytest.mark.parametrize("step", [pytest.param(0.001, marks=pytest.mark.slow), 0.0137, 0.1])
def test_a_short_extra_slip_does_not_halve_the_period(step: float) -> None:
    found = measure(record(cycle(PERIOD, [LONG, SHORT], 20), times(step)))
    assert found is not None
    assert found.period == pytest.approx(PERIOD, rel=1e-12)
    assert found.stops_per_period == 2
    assert found.stuck_fraction == pytest.approx(1.0 - 1.64 / PERIOD, rel=1e-10)
    assert found.mean_speed == pytest.approx(MEAN_OF_BOTH, rel=1e-10)


def test_periods_that_have_not_settled_are_left_out() -> None:
    slips = [Slip(0.5, 2.0, 30.0), Slip(3.0, 4.5, 25.0)]
    settled = [Slip(slip.release + 5.0, slip.stop + 5.0, slip.peak) for slip in cycle(PERIOD, [LONG], 4)]
    found = measure(record(slips + settled, times(0.01, 18.5)))
    assert found is not None
    assert found.start >= settled[0].stop - 1e-9
    assert found.period == pytest.approx(PERIOD, rel=1e-9)
    assert found.peak == pytest.approx(18.76, rel=1e-9)


def test_a_bit_that_has_kept_turning_is_measured_over_the_last_20_seconds() -> None:
    slips = [*cycle(PERIOD, [LONG], 3), Slip(11.0, 211.0, 5.0)]
    found = measure(record(slips, times(0.01, 111.0)))
    assert found is not None
    assert found.period is None
    assert (found.start, found.end) == pytest.approx((91.0, 111.0))
    assert "the last 20 s, 91 s to 111 s" in found.window
    assert found.stuck_fraction == 0.0
    angle = 5.0 * 200.0 / math.pi * math.cos(math.pi * 80.0 / 200.0)
    assert found.mean_speed == pytest.approx(angle / 20.0, rel=1e-9)
    assert found.peak == 5.0


def test_a_bit_that_stands_still_has_an_infinite_index_and_never_nan() -> None:
    found = measure(record([Slip(1.0, 2.0, 3.0)], times(0.1, 60.0)))
    assert found is not None
    assert found.ssi == math.inf
    assert found.mean_speed == 0.0
    assert found.stuck_fraction == pytest.approx(1.0)


def test_a_run_shorter_than_20_seconds_is_measured_as_a_whole() -> None:
    found = measure(record([Slip(1.0, 2.0, 3.0)], times(0.1, 5.0)))
    assert found is not None
    assert "the whole run, 0 s to 5 s" in found.window
    assert found.peak == pytest.approx(3.0)
    assert found.mean_speed == pytest.approx(3.0 * 2.0 / math.pi / 5.0)


def test_stops_that_do_not_repeat_give_no_period() -> None:
    generator = np.random.default_rng(1)
    starts = np.cumsum(generator.uniform(1.5, 4.0, 16))
    found = measure(record([Slip(start, start + 1.0, 10.0) for start in starts], times(0.01, float(starts[-1]) + 2.0)))
    assert found is not None
    assert found.period is None
    assert "stops that do not repeat" in found.window
    assert found.end == pytest.approx(starts[-1] + 1.0)


def test_stops_lost_within_a_step_are_noticed() -> None:
    found = measure(record(cycle(PERIOD, [LONG], 20), times(7.0, 63.0)))
    assert found is not None
    assert found.period is None
    assert "too long to show every stop" in found.window


@pytest.mark.parametrize("step", [1.9, 2.0, 4.0])
def test_steps_longer_than_a_slip_lose_no_digit(step: float) -> None:
    found = measure(record(cycle(PERIOD, [LONG], 40), times(step, 120.0)))
    assert found is not None
    assert found.period == pytest.approx(PERIOD, rel=1e-12)
    assert found.stuck_fraction == pytest.approx(1.0 - 1.6 / PERIOD, rel=1e-10)
    assert found.mean_speed == pytest.approx(MEAN, rel=1e-10)


def test_stops_lost_long_ago_do_not_matter() -> None:
    early = cycle(0.2, [Slip(0.05, 0.1, 1.0)], 4)
    late = [Slip(slip.release + 2.0, slip.stop + 2.0, slip.peak) for slip in cycle(PERIOD, [LONG], 10)]
    found = measure(record(early + late, times(0.9, 36.0)))
    assert found is not None
    assert found.period == pytest.approx(PERIOD, rel=1e-12)


def test_a_component_without_a_bit_is_not_measured() -> None:
    result = record([LONG], times(0.1))
    assert measure(result, "law") is None
