"""Derivatives of outputs by time: of the plant against the oracle, of laws and program against their formulas."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_double, c_int
from dataclasses import replace

import numpy as np
import pytest

from fmu_src.fmus import MODELS
from tests.oracle import OracleSolution
from tests.plant import theory
from tests.plant.drive import PLANT, Drive, points, travel
from tests.plant.fmi import ERROR, Instance, must
from tests.plant.judge import away_from
from tests.plant.programs import CASES, PAPER, RAMPS, Case, solved

MOVING = (
    "bit_speed", "top_speed", "bit_torque", "top_torque", "bit_angle", "top_angle", "energy", "work_in", "bit_loss",
    "drive_work", "top_loss",
)  # fmt: skip
COUNTED = ("last_stop_time", "last_release_time", "folded_energy")
GAP = 1e-4
"""Between the points of a difference quotient [s]."""
BACKWARD = np.array([25 / 12, -4.0, 3.0, -4 / 3, 1 / 4]) / GAP
"""The derivative at the first of five points that go back in time, of order four."""
BAR = 1e-6
"""Of the greatest rate of a run: the oracle's rounding, a few 1e-12 of a value, is divided by the gap."""


def kinks(case: Case, solution: OracleSolution) -> np.ndarray:
    """Return all times at which a rate may jump [s]: changes and events, and their echoes at either end."""
    away = case.parameters.travel_time
    first = [[0.0], case.omega.times, case.wob.times, solution.stops, solution.releases, solution.crossings]
    return np.add.outer(np.concatenate(first), np.arange(case.end // away + 2) * away).ravel()


def smooth_times(case: Case, solution: OracleSolution) -> np.ndarray:
    """Return random times with no kink within reach of the difference quotient before them."""
    times = np.sort(np.random.default_rng(1).uniform(0.01, case.end, 300))
    return times[away_from(times - 2 * GAP, kinks(case, solution), 2.5 * GAP)]


@pytest.mark.parametrize("name", [*CASES, *RAMPS])
def test_rates_of_the_plant_are_those_of_the_oracle(name):
    case, solution = (CASES | RAMPS)[name], solved(name)
    times = smooth_times(case, solution)
    before = solution(times - GAP * np.arange(5)[:, None])
    wanted, seen, stuck = set(times.tolist()), [], []
    ends = points(times, case.omega, case.wob)
    for end, plant in zip(ends.tolist(), travel(case.parameters, case.omega, case.wob, ends), strict=True):
        if end in wanted:
            seen.append([plant.rate(output) for output in MOVING])
            stuck.append(plant.get("bit_stuck"))
    assert len(seen) == len(times) > 250
    assert 0 < sum(stuck) < len(stuck)
    for output, rates in zip(MOVING, np.array(seen).T, strict=True):
        due = BACKWARD @ before[output]
        assert np.abs(rates - due).max() <= BAR * np.abs(due).max(), output


def test_rates_fit_each_other_and_the_outputs():
    case = CASES["inputs that jump on no grid"]
    drive = case.parameters.c_a
    for plant in travel(case.parameters, case.omega, case.wob, points(np.arange(1, 150) * 0.1, case.omega, case.wob)):
        now, rate = plant.named(), {name: plant.rate(name) for name in (*MOVING, *COUNTED, "stuck_time")}
        assert (rate["bit_angle"], rate["top_angle"]) == (now["bit_speed"], now["top_speed"])
        assert rate["work_in"] == now["top_torque"] * now["top_speed"]
        assert rate["bit_loss"] == now["bit_torque"] * now["bit_speed"]
        assert rate["energy"] == rate["work_in"] - rate["bit_loss"]
        omega = case.omega.line(plant.time - 1e-9, plant.time - 1e-9)[0]
        assert rate["drive_work"] == now["top_torque"] * omega
        assert rate["top_loss"] == now["top_torque"] * (omega - now["top_speed"])
        assert rate["top_torque"] == pytest.approx(-drive * rate["top_speed"], rel=1e-12)
        assert rate["stuck_time"] == now["bit_stuck"]
        assert [rate[name] for name in COUNTED] == [0.0, 0.0, 0.0]
        if now["bit_stuck"]:
            assert rate["bit_speed"] == 0.0


@pytest.mark.parametrize("omega", [10.0, -10.0])
def test_an_extreme_moves_while_the_speed_is_at_it(omega):
    moving = {"bit_speed_min": 0, "bit_speed_max": 0}
    with Drive(PLANT, {"Omega": omega}) as plant:
        for k in range(1, 700):
            plant.go(0.01 * k)
            now, rate = plant.named(), plant.rate("bit_speed")
            for name, furthest in (("bit_speed_min", min), ("bit_speed_max", max)):
                at_it = now["bit_speed"] == now[name]
                assert plant.rate(name) == (furthest(rate, 0.0) if at_it else 0.0)
                moving[name] += plant.rate(name) != 0.0
    assert min(moving.values()) > 50


@pytest.mark.parametrize("event", ["last_stop_time", "last_release_time"])
def test_rates_just_before_and_after_an_event_are_those_of_either_side(event):
    with Drive(PLANT, {}) as ahead:
        ahead.go(4.5 if event == "last_stop_time" else 3.0)
        time = ahead.get(event)
    turning = []
    for shift in (-1e-7, 1e-7):
        with Drive(PLANT, {}) as plant:
            plant.go(time + shift)
            rate = plant.rate("bit_speed")
            speed = plant.get("bit_speed")
            plant.go(time + shift + 1e-9)
            assert (plant.get("bit_speed") - speed) / 1e-9 == pytest.approx(rate, rel=1e-4, abs=1e-4)
            turning.append(rate)
    stopped, moving = turning if event == "last_release_time" else turning[::-1]
    assert stopped == 0.0
    assert abs(moving) > 1e-3


@pytest.mark.parametrize("speed", [8.0, -8.0])
def test_rates_at_the_start_are_limits_from_the_right(speed):
    # inputs set to go on along slopes before the initialization ends; the equation of motion of bit and top at once
    p = replace(PAPER, initial_speed=speed, initial_torque=3000.0)
    weight, slope, rise = 6e4, 1.5, -2000.0
    with Instance(PLANT) as plant:
        must(plant, plant.set(initial_speed=speed, initial_torque=3000.0, Omega=12.0, WOB=weight))
        must(plant, plant.set_slopes(Omega=slope, WOB=rise))
        must(plant, plant.initialize())
        rate = {name: plant.rate(name) for name in ("bit_speed", "top_speed", "top_torque", "bit_torque")}
    torque = theory.torque_on_bit(p, weight, speed)
    pull = 2 * p.impedance * p.initial_down - p.impedance * speed - torque
    assert rate["bit_speed"] == pytest.approx(pull / p.I_B, rel=1e-10)
    assert rate["top_speed"] == pytest.approx(p.transmission * slope, rel=1e-12)
    assert rate["top_torque"] == pytest.approx(p.c_a * (1 - p.transmission) * slope, rel=1e-12)
    by_weight = (torque - p.c_b * speed) / weight
    along = theory.slope_of_torque(p, weight, abs(speed)) * rate["bit_speed"] + by_weight * rise
    assert rate["bit_torque"] == pytest.approx(along, rel=1e-9)


def test_rates_after_a_ramp_are_limits_from_the_left():
    # the ramp ends at the communication point: it still counts there, and no more a moment later
    with Drive(PLANT, {}) as plant:
        must(plant, plant.set_slopes(Omega=2.0))
        plant.go(0.25)
        assert plant.rate("top_speed") == pytest.approx(PAPER.transmission * 2.0, rel=1e-12)
        plant.go(0.2500001)
        assert plant.rate("top_speed") == 0.0


PRINTED = {"c_1": 0.4, "c_2": 1.5, "c_b": 15.0, "Omega_max": 1e4}
TRACKING = PRINTED | {"form": 2}
INPUTS = {"top_speed": 9.0, "bit_speed": 7.0, "bit_speed_ref": 11.0, "bit_torque_ref": 7000.0}
SLOPES = {"top_speed": 3.0, "bit_speed": -2.0, "bit_speed_ref": 0.5, "bit_torque_ref": 400.0}


def printed_law(top_speed: float, bit_speed: float, bit_speed_ref: float, bit_torque_ref: float) -> float:
    """Eq. (9) with the parameters of `PRINTED`."""
    ratio = 15.0 / 2000.0
    return (
        0.4 * top_speed
        + 2 * (ratio * 0.6) ** 0.5 * bit_speed
        + 2 * (1.5 * 0.6) ** 0.5 * bit_speed_ref
        - 1.5 * bit_speed_ref**2 / top_speed
        - 2 * (1.5 * ratio) ** 0.5 * bit_speed * bit_speed_ref / top_speed
    )


def tracking_law(top_speed: float, bit_speed: float, bit_speed_ref: float, bit_torque_ref: float) -> float:
    """The tracking form with the parameters of `TRACKING`."""
    wanted = bit_speed_ref + bit_torque_ref / 2000.0
    matching = 2 * (0.6 * 15.0 / 2000.0) ** 0.5
    return wanted + 0.4 * (top_speed - bit_speed_ref) + matching * (bit_speed - bit_speed_ref)


@pytest.mark.parametrize(("start", "formula"), [(PRINTED, printed_law), (TRACKING, tracking_law)])
def test_rate_of_a_drive_law_follows_from_those_of_its_inputs(start, formula: Callable[..., float]):
    def along(after: float) -> float:
        return formula(**{name: INPUTS[name] + SLOPES[name] * after for name in INPUTS})

    with Drive("DissipativeLaw", start | INPUTS) as law:
        assert law.rate("Omega") == 0.0
        must(law, law.set_slopes(**SLOPES))
        law.go(0.25)
        assert law.get("Omega") == pytest.approx(along(0.25), rel=1e-13)
        assert law.rate("Omega") == pytest.approx((along(0.25 + 1e-5) - along(0.25 - 1e-5)) / 2e-5, rel=1e-8)
        law.go(0.5)
        assert (law.get("Omega"), law.rate("Omega")) == (pytest.approx(along(0.0), rel=1e-13), 0.0)


def after_ramp(model: str, start: dict[str, float], **slopes: float) -> tuple[float, float]:
    """Return output and rate of a law after a step of 1 s along slopes."""
    output = "WOB" if model == "WeightOnBitLaw" else "Omega"
    with Drive(model, start) as law:
        must(law, law.set_slopes(**slopes))
        law.go(1.0)
        return law.get(output), law.rate(output)


@pytest.mark.parametrize(
    ("bit_speed", "slope", "weight", "rate"),
    [
        (3.0, 2.0, 97347.0 + 25000.0, 10000.0),
        (-3.0, -2.0, 97347.0 + 25000.0, 10000.0),
        (3.0, -2.0, 97347.0 + 5000.0, -10000.0),
        # through rest, and up to rest exactly: the left limit
        (1.0, -2.0, 97347.0 + 5000.0, 10000.0),
        (2.0, -2.0, 97347.0, -10000.0),
        (-2.0, 2.0, 97347.0, -10000.0),
        # at the limit
        (50.0, 2.0, 300000.0, 0.0),
        (50.0, 0.0, 300000.0, 0.0),
    ],
)
def test_rate_of_the_weight_is_the_limit_from_the_left(bit_speed, slope, weight, rate):
    assert after_ramp("WeightOnBitLaw", {"bit_speed": bit_speed}, bit_speed=slope) == (weight, rate)


def test_rate_of_a_weight_that_comes_to_its_limit_exactly_is_the_limit_from_the_left():
    start = {"K_w": 1000.0, "WOB_0": 1000.0, "WOB_max": 5000.0}
    assert after_ramp("WeightOnBitLaw", start | {"bit_speed": 3.0}, bit_speed=1.0) == (5000.0, 1000.0)
    assert after_ramp("WeightOnBitLaw", start | {"bit_speed": 5.0}, bit_speed=-1.0) == (5000.0, 0.0)


def test_rate_of_omega_at_its_limit_is_zero():
    start = TRACKING | INPUTS | {"Omega_max": 5.0}
    assert after_ramp("DissipativeLaw", start, **SLOPES) == (5.0, 0.0)


def test_divisor_that_is_held_does_not_change():
    # all but the divisor goes on along the slope: Omega + c_2 r^2 / d is linear in the top speed then
    start = PRINTED | INPUTS | {"top_speed": 0.001, "top_speed_min": 0.5}
    _, rate = after_ramp("DissipativeLaw", start, top_speed=0.1)
    assert rate == pytest.approx(0.4 * 0.1, rel=1e-12)


def test_rate_at_the_start_is_that_of_the_slopes_set_before_it():
    with Instance("WeightOnBitLaw") as law:
        must(law, law.set_slopes(bit_speed=-2.0))
        must(law, law.initialize())
        assert law.rate("WOB") == 10000.0
        assert law.get("WOB") == 97347.0


def ask(fmu: Instance, name: str, order: int) -> int:
    """Ask for one derivative and return the status."""
    return fmu.call("GetRealOutputDerivatives", fmu.references([name]), 1, (c_int * 1)(order), byref(c_double()))


@pytest.mark.parametrize("model", MODELS)
def test_what_the_description_promises_is_kept(model):
    with Drive(model, {}) as fmu:
        assert fmu.library.description.coSimulation.maxOutputDerivativeOrder == 1
        for name, variable in fmu.variables.items():
            if variable.causality == "output" and variable.type == "Real":
                assert np.isfinite(fmu.rate(name))
            elif variable.type == "Real":
                assert ask(fmu, name, 1) == ERROR
                assert fmu.messages[-1].text.endswith(f"{name} is no output")
            else:
                assert ask(fmu, name, 1) == ERROR
        fmu.go(1.0)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("order", [0, 2, -1])
def test_other_orders_are_refused(model, order):
    with Drive(model, {}) as fmu:
        name = next(name for name, variable in fmu.variables.items() if variable.causality == "output")
        assert ask(fmu, name, order) == ERROR
        assert fmu.messages[-1].text.endswith(f"the order for {name} is {order}; expected 1")
        fmu.go(1.0)


def test_rates_can_be_asked_for_in_one_call():
    with Drive(PLANT, {}) as plant:
        plant.go(3.0)
        n = len(MOVING)
        rates = (c_double * n)()
        must(plant, plant.call("GetRealOutputDerivatives", plant.references(MOVING), n, (c_int * n)(*[1] * n), rates))
        assert list(rates) == [plant.rate(name) for name in MOVING]


def test_rates_are_part_of_the_saved_state():
    with Drive("DissipativeLaw", TRACKING | INPUTS) as law, Drive("DissipativeLaw", {}) as other:
        must(law, law.set_slopes(**SLOPES))
        law.go(0.25)
        rate = law.rate("Omega")
        must(other, other.restore(law.serialized()))
        assert other.rate("Omega") == rate != 0.0


def test_parameters_set_since_do_not_count():
    with Drive("DissipativeLaw", TRACKING | INPUTS) as law:
        must(law, law.set_slopes(**SLOPES))
        law.go(0.25)
        rate = law.rate("Omega")
        law.put(c_1=-3.0, top_speed=1.0)
        assert law.rate("Omega") == rate
