"""PI and PID control of the rotor's speed: what it frees and what not, and that nothing jumps or winds up."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

from models.controllers.speed_pid import stiff, tuned
from models.controllers.virtual_drive import TopOfString
from tests.laws.rig import STEP, engaged_on_a_rotor
from tests.plant.drive import Drive

pytestmark = pytest.mark.slow

PHASES = (0.0, 0.8, 1.6, 2.4)
"""Of a cycle of 3.2 s [s]."""
LONG = {"3000 m": {"L": 3000.0}, "5000 m": {"L": 5000.0, "WOB": 80000.0}}
"""Strings, and the weight on one of them, at 12 rad/s."""
LONG_PHASES = (0.0, 1.5, 3.0, 4.5, 6.0, 7.5)
LIGHT = {"J_r": 500.0}
TUNED, STIFF, OWN = 1, 2, 3
PACKAGINGS = ("native", "python")


@pytest.mark.parametrize(("mode", "speed", "phase"), list(product((TUNED, STIFF), (8.0, 9.0, 10.0), PHASES)))
def test_a_heavy_rotor_leaves_the_bit_sticking_stiff_or_tuned(mode: int, speed: float, phase: float) -> None:
    outcome = engaged_on_a_rotor(speed, phase, {"mode": mode})
    assert outcome.last_stuck > 55.0
    assert outcome.severity > 1.0


@pytest.mark.parametrize(("string", "phase"), list(product(LONG, LONG_PHASES)))
def test_tuned_gains_and_a_light_rotor_free_long_strings(string: str, phase: float) -> None:
    outcome = engaged_on_a_rotor(12.0, phase, {"mode": TUNED, **LIGHT}, LIGHT, LONG[string])
    assert outcome.last_stuck <= 10.0
    assert outcome.severity < 0.01


@pytest.mark.parametrize(("string", "mode", "inertia"), [
    *((string, TUNED, 2900.0) for string in LONG), *((string, STIFF, 500.0) for string in LONG),
])  # fmt: skip
def test_neither_tuning_nor_a_light_rotor_frees_long_strings_alone(string: str, mode: int, inertia: float) -> None:
    rotor = {"J_r": inertia}
    outcome = engaged_on_a_rotor(12.0, 0.0, {"mode": mode, **rotor}, rotor, LONG[string])
    assert outcome.last_stuck > 50.0


def test_tuned_gains_make_rotor_and_controller_a_damper_at_the_stick_slip_frequency() -> None:
    string, inertia = TopOfString(), 2900.0
    gains, frequency = tuned(string, inertia), string.stick_slip_frequency
    met = gains.proportional + gains.integral / (1j * frequency) + 1j * frequency * inertia
    assert met == pytest.approx(4.0 * string.impedance, rel=1e-12)
    assert stiff(string, inertia)[:2] == (50.0 * string.impedance, 5.0 * inertia)


def test_on_the_top_of_the_string_ahead_of_the_slip_it_reflects_nearly_all() -> None:
    """Torque P (r - y) + ... on y itself: the stiffer the gains, the nearer the reflection comes to -1."""
    Z = TopOfString().impedance
    sizes = [(Z - met) / (Z + met) for met in (4.0 * Z, 50.0 * Z)]
    assert sizes[0] == pytest.approx(-0.6)
    assert sizes[1] < -0.96


def torques(packaging: str, parameters: dict[str, float], speeds: list[float], switch: int = 10**9) -> np.ndarray:
    """Return the torque at steps of 10 ms over speeds, the law being switched off at one of them."""
    found: list[float] = []
    with Drive("SpeedPid", {"Omega": speeds[0], "torque_initial": 7000.0, **parameters}, packaging) as law:
        for k, speed in enumerate(speeds):
            law.put(Omega=speed)
            if k == switch:
                law.put(enabled=False)
            law.go(STEP * (k + 1))
            found.append(law.get("motor_torque"))
    return np.array(found)


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("mode", [TUNED, OWN])
def test_a_switch_makes_no_bump(packaging: str, mode: int) -> None:
    speeds = [10.0 + math.sin(2.5 * k * STEP) for k in range(400)]
    parameters = {"mode": mode, "K_d": 200.0}
    plain, switched = torques(packaging, parameters, speeds), torques(packaging, parameters, speeds, 200)
    assert switched[:201] == pytest.approx(plain[:201], rel=1e-12)
    # the next step is the stiff controller's own: 50 Z times what the speed changes by
    assert abs(switched[201] - switched[200]) <= 50.0 * TopOfString().impedance * 2.5 * STEP * 1.2 + 200.0


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_a_limit_that_has_held_winds_nothing_up(packaging: str) -> None:
    returns: list[int] = []
    for stalled in (100, 3000):
        speeds = [2.0] * stalled + [10.5] * 2000
        torque = torques(packaging, {"mode": TUNED, "rate_limit": 1e3, "torque_max": 15000.0}, speeds)
        assert torque.max() == 15000.0
        returns.append(int(np.argmax(torque[stalled:] < 15000.0)))
    assert returns[0] == returns[1] == 0


def test_the_set_point_goes_at_its_rate() -> None:
    with Drive("SpeedPid", {"mode": OWN, "K_p": 100.0, "K_i": 0.0, "Omega": 0.0, "speed_ref": 10.0}) as law:
        for k in range(600):
            law.go(STEP * (k + 1))
            assert law.get("motor_torque") == pytest.approx(100.0 * min(2.0 * STEP * (k + 1), 10.0), rel=1e-10)
