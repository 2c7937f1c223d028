"""A drive as real ones are: what its lag, limits, samples and noise do, and to a law that frees with an ideal one."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

from models.controllers.virtual_drive import TopOfString, soft_torque
from models.numerics.noise import normal
from tests.laws.rig import engaged_behind_a_drive
from tests.plant.drive import PLANT, Drive
from tests.plant.fmi import DISCARD, OK, Instance, must

pytestmark = pytest.mark.slow

PHASES = (0.0, 0.8, 1.6, 2.4)
"""Of a cycle of 3.2 s [s]."""
NOISE = {"speed_noise": 0.05, "torque_noise": 150.0}
PACKAGINGS = ("native", "python")


@pytest.mark.parametrize(("speed", "phase"), list(product((8.0, 9.0, 10.0), PHASES)))
def test_soft_torque_frees_behind_lag_rate_limit_and_noise(speed: float, phase: float) -> None:
    """Lag 20 ms, rate 10 rad/s^2, 0.05 rad/s and 150 N m of noise: the bit swings by what the noise makes it."""
    outcome = engaged_behind_a_drive("SoftTorque", speed, phase, drive=NOISE)
    assert outcome.last_stuck <= 20.0
    assert outcome.severity <= 0.05
    assert outcome.columns["limit_active"].max() == 0


FAILS = {
    "half the rate": ({}, {"rate_limit": 5.0}),
    "a rotor with 20 kN m": ({}, {"mode": 2, "torque_max": 20e3}),
    "2.5 Z": ({"mode": 3, "P": 2.5 * TopOfString().impedance, "K": soft_torque(TopOfString(), 2.5).stiffness}, {}),
}


@pytest.mark.parametrize(("what", "phase"), list(product(FAILS, PHASES)))
def test_what_is_too_slow_too_weak_or_too_stiff_leaves_the_bit_sticking(what: str, phase: float) -> None:
    law, drive = FAILS[what]
    outcome = engaged_behind_a_drive("SoftTorque", 8.0, phase, law, drive)
    assert outcome.last_stuck > 55.0
    assert outcome.severity > 1.0


@pytest.mark.parametrize("phase", PHASES)
def test_delay_beyond_half_the_filter_time_makes_law_and_drive_swing(phase: float) -> None:
    """The bit comes free, but waves with the period of the delay are amplified; a longer filter ends that."""
    late = {"delay": 0.05}
    swinging = engaged_behind_a_drive("SoftTorque", 8.0, phase, drive=late)
    assert swinging.severity > 0.2
    # the delay, the lag of 20 ms, and the sample from which a command acts
    quiet = engaged_behind_a_drive("SoftTorque", 9.0, phase, {"filter_time": 2.0 * 0.08}, late)
    assert quiet.severity < 2e-3


def follow(packaging: str, parameters: dict[str, float], count: int, **inputs: float) -> list[dict[str, float]]:
    """Return what a drive puts out at the ends of steps of 10 ms, inputs being set after the start."""
    rows: list[dict[str, float]] = []
    with Drive("TopDrive", parameters, packaging) as drive:
        for name, value in inputs.items():
            drive.put(**{name: value})
        for k in range(count):
            drive.go(0.01 * (k + 1))
            rows.append(drive.named())
    return rows


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_a_small_step_comes_through_the_lag_and_a_large_one_at_the_rate(packaging: str) -> None:
    start = {"lag": 0.1, "rate_limit": 10.0, "top_torque": 5000.0}
    small = [row["Omega"] for row in follow(packaging, start, 60, Omega_command=10.5)]
    # the command is sampled at 10 ms
    assert small[0] == 10.0
    assert small[29] == pytest.approx(10.5 - 0.5 * math.exp(-0.29 / 0.1), rel=1e-12)
    large = [row["Omega"] for row in follow(packaging, start, 60, Omega_command=2.0)]
    assert large[20] == pytest.approx(8.0, abs=1e-12)
    assert np.diff(large).min() == pytest.approx(-0.1, abs=1e-12)


def off_bottom(packaging: str, seconds: float, **later: float) -> list[dict[str, float]]:
    """Return what a drive and a string that nothing holds do; after half the time something else is asked for."""
    rows: list[dict[str, float]] = []
    with Drive("TopDrive", {}, packaging) as drive, Drive(PLANT, {"WOB": 0.0, "c_b": 0.0}) as plant:
        count = round(100.0 * seconds)
        for k in range(count):
            if later and 2 * k == count:
                drive.put(**later)
            drive.put(top_torque=plant.get("top_torque"))
            drive.go(0.01 * (k + 1))
            plant.put(Omega=drive.get("Omega"))
            plant.go(0.01 * (k + 1))
            rows.append(drive.named() | {name: plant.get(name) for name in ("bit_speed", "work_in")})
    return rows


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_a_drive_that_does_not_brake_gives_a_free_string_no_energy(packaging: str) -> None:
    """A string off bottom swings without loss but that of the slip, and may turn the drive, but not be turned by it."""
    rows = off_bottom(packaging, 60.0)
    assert max(row["bit_speed"] for row in rows) < 20.0
    assert rows[-1]["work_in"] == pytest.approx(rows[len(rows) // 2]["work_in"], abs=1.0)
    assert rows[-1]["bit_speed"] == pytest.approx(rows[-1]["Omega"], abs=1e-3)
    assert 10.0 <= rows[-1]["Omega"] < 10.5


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_a_drive_that_does_not_brake_goes_no_slower_than_the_string_lets_it(packaging: str) -> None:
    rows = off_bottom(packaging, 60.0, Omega_command=2.0)
    assert rows[-1]["Omega"] == pytest.approx(rows[len(rows) // 2 - 1]["Omega"], abs=1e-2)
    assert rows[-1]["limit_active"] == 1


@pytest.mark.parametrize("delay", [0.0, 0.03, 0.64])
def test_a_command_comes_late_by_the_delay(delay: float) -> None:
    rows = follow("native", {"lag": 0.0, "rate_limit": 1e6, "delay": delay}, 80, Omega_command=12.0)
    changed = next(k for k, row in enumerate(rows) if row["Omega"] == 12.0)
    assert 0.01 * (changed + 1) == pytest.approx(0.02 + delay)


def test_a_longer_delay_than_is_kept_is_refused() -> None:
    with Instance("TopDrive") as drive:
        must(drive, drive.set(delay=0.65))
        assert drive.initialize() != OK
        assert drive.messages[-1].text.endswith("delay is 0.65 s; expected at most 64 sample times, 0.64 s")


def test_a_step_with_too_many_samples_is_refused() -> None:
    with Drive("TopDrive", {}) as drive:
        assert drive.step(0.0, 2e4) == DISCARD
        assert "more than 1e+06 samples" in drive.messages[-1].text
        drive.go(1.0)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_how_a_step_is_divided_makes_no_difference(packaging: str) -> None:
    rows: list[list[float]] = []
    for parts in (1, 7):
        with Drive("TopDrive", {"mode": 2, **NOISE, "Omega_command": 10.0, "top_torque": 5000.0}, packaging) as drive:
            drive.put(Omega_command=12.0)
            for k in range(40 * parts):
                drive.go((k + 1) * 0.0125 / parts)
            rows.append(drive.outputs())
    assert rows[0] == pytest.approx(rows[1], rel=1e-9)


@pytest.mark.parametrize("mode", [2, 3])
@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_torque_and_power_stay_within_their_limits_whatever_is_asked(mode: int, packaging: str) -> None:
    random = np.random.default_rng(mode)
    held = 0
    with Drive("TopDrive", {"mode": mode, **NOISE}, packaging) as drive:
        for k in range(1000):
            asked = {"Omega_command": random.uniform(-40.0, 60.0), "motor_torque": random.uniform(-9e4, 9e4)}
            for name, value in (asked | {"top_torque": random.uniform(-2e4, 3e4)}).items():
                drive.put(**{name: float(value)})
            speed = drive.get("Omega")
            drive.go(0.01 * (k + 1))
            motor = drive.get("motor_torque_applied")
            speed = drive.get("Omega")
            held += int(drive.get("limit_active"))
            assert 0.0 <= motor <= 6e4
            assert motor * abs(speed) <= 8e5 * (1.0 + 1e-12)
    assert 100 < held < 1000


def test_a_limit_that_has_held_winds_nothing_up() -> None:
    """A rotor stalled against its limit for a minute overshoots no more than one stalled for a second."""
    overshoots: list[float] = []
    for stalled in (100, 6000):
        with Drive("TopDrive", {"mode": 2, "torque_max": 1e4, "Omega_command": 0.0, "power_max": 1e9}) as drive:
            drive.put(Omega_command=8.0)
            speeds: list[float] = []
            for k in range(stalled + 3000):
                stuck = k < stalled
                drive.put(top_torque=(1e4 if drive.get("Omega") > 0.0 else 0.0) if stuck else 500.0)
                drive.go(0.01 * (k + 1))
                speeds.append(drive.get("Omega"))
            overshoots.append(max(speeds[stalled:]))
    assert overshoots[0] == pytest.approx(overshoots[1], abs=0.2)
    assert overshoots[1] < 9.5


def test_speed_is_held_where_the_string_takes_what_the_motor_can_give() -> None:
    """Against a string that takes more torque the more it is turned, with the admittance of slip and wave."""
    admittance = 1.0 / 2000.0 + 1.0 / TopOfString().impedance
    limit = 9000.0
    with Drive("TopDrive", {"torque_max": limit, "Omega_command": 10.0, "top_torque": 8000.0}) as drive:
        drive.put(Omega_command=40.0)
        torque = 8000.0
        for k in range(400):
            before = drive.get("Omega")
            drive.put(top_torque=torque)
            drive.go(0.01 * (k + 1))
            torque += (drive.get("Omega") - before) / admittance
        assert drive.get("limit_active") == 1
        # what the rate limit lets it gain until the sample that shows it, and the one from which the motor gives way
        assert torque == pytest.approx(limit, abs=2.0 * 10.0 * 0.01 / admittance)


def test_noise_is_nearly_normal_and_that_of_its_seed() -> None:
    state, drawn = 1.0, []
    for _ in range(20000):
        value, state = normal(state)
        drawn.append(value)
    assert np.mean(drawn) == pytest.approx(0.0, abs=4.0 / math.sqrt(20000))
    assert np.std(drawn) == pytest.approx(1.0, abs=0.02)
    assert np.corrcoef(drawn[:-1], drawn[1:])[0, 1] == pytest.approx(0.0, abs=0.03)
    shown = [
        [row["Omega_measured"] for row in follow(packaging, NOISE | {"seed": seed}, 200)]
        for packaging, seed in (("native", 1), ("python", 1), ("native", 2))
    ]
    assert shown[0] == shown[1] != shown[2]
    assert np.std(shown[0]) == pytest.approx(0.05, rel=0.15)


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("start", [0.0, 2e5, 1e7])
def test_no_sample_is_missed_however_late_it_is(start: float, packaging: str) -> None:
    """At 2e5 s, two days and more, a last bit is 3e-11 s, by which steps are now longer, now shorter than samples."""
    seen: list[float] = []
    with Drive("TopDrive", {"speed_noise": 0.05}, packaging, start=start) as drive:
        for k in range(2000):
            drive.go(start + (k + 1) * 0.01)
            seen.append(drive.get("top_speed_measured"))
    assert len(set(seen)) == 2000
