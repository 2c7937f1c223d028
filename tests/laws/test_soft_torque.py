"""Soft torque and impedance matching: what they free, what they are equal to, and that nothing jumps."""

from __future__ import annotations

import math
from functools import cache
from itertools import product

import numpy as np
import pytest
from scipy.optimize import brentq

from cosim import Component, Connection, Constant, Method, Scenario, Step, System, simulate
from models.controllers.virtual_drive import TopOfString, soft_torque
from tests.laws.rig import STEP, WEIGHT, engaged
from tests.plant.drive import PLANT, Drive
from tests.plant.programs import PAPER
from tests.plant.theory import torque_on_bit

pytestmark = pytest.mark.slow

PHASES = (0.0, 0.8, 1.6, 2.4)
"""Of a cycle of 3.2 s [s]."""
MODES = {"soft_torque": (1, 20.0), "z_torque": (2, 30.0)}
"""Number of a mode, and within what time it must have freed the string [s]."""
Z = PAPER.impedance


def steady_speed(asked: float) -> float:
    """Return the bit speed in equilibrium with an ordinary drive [rad/s]."""
    return brentq(lambda v: PAPER.c_a * (asked - v) - torque_on_bit(PAPER, WEIGHT, v), 3.0, asked)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(("speed", "phase"), list(product((8.0, 9.0, 10.0), PHASES)))
def test_it_frees_full_stick_slip_at_any_phase(mode: str, speed: float, phase: float) -> None:
    number, within = MODES[mode]
    outcome = engaged("SoftTorque", speed, phase, {"mode": number})
    assert outcome.last_stuck <= within
    assert outcome.severity < 1e-3
    assert abs(outcome.mean - steady_speed(speed)) <= 0.005


def test_a_drive_too_stiff_does_not_free_it() -> None:
    outcome = engaged("SoftTorque", 8.0, 0.0, {"mode": 3, "P": 2.5 * Z, "K": soft_torque(TopOfString(), 2.5).stiffness})
    assert outcome.last_stuck > 59.0
    assert outcome.severity > 1.0


def test_compensated_slip_turns_the_top_as_asked_for() -> None:
    outcome = engaged("SoftTorque", 10.0, 0.8, {"slip": 2})
    assert outcome.mean == pytest.approx(10.0, abs=0.005)


@pytest.mark.parametrize(("I_B", "L"), [(89.0, 1172.0), (311.0, 2000.0), (0.01, 1e5), (1e6, 1.0), (1e-3, 1.0)])
def test_stick_slip_frequency_solves_its_equation(I_B: float, L: float) -> None:
    string = TopOfString(I_B=I_B, L=L)
    away = L * math.sqrt(string.I / (string.G * string.J))
    k = string.impedance * away / I_B
    root = brentq(lambda x: x * math.sin(x) - k * math.cos(x), 0.0, math.pi / 2, xtol=1e-15)
    assert string.stick_slip_frequency * away == pytest.approx(root, rel=1e-12)


def rotating(packaging: str, **parameters: float) -> Drive:
    """Return a law that has seen a steady rotation at 10 rad/s for ever."""
    torque = 7589.626471
    start = {"top_speed": 10.0 - torque / 2000.0, "top_torque": torque, "speed_ref": 10.0, **parameters}
    return Drive("SoftTorque", start, packaging)


@pytest.mark.parametrize("packaging", ["native", "python"])
def test_it_keeps_a_steady_rotation(packaging: str) -> None:
    with rotating(packaging) as law:
        for k in range(500):
            law.go((k + 1) * STEP)
            assert law.get("Omega") == pytest.approx(10.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_no_switch_makes_the_drive_jump(seed: int) -> None:
    """Switched at random times in full cycle, no step of Omega is greater than those which law or speed_ref make."""
    random = np.random.default_rng(seed)
    time = np.arange(1, 2001) * STEP
    tau = 7000.0 + 6000.0 * np.sin(2.0 * time) + 500.0 * np.sin(17.0 * time)
    steps: dict[str, list[float]] = {"always": [], "switched": []}
    for name in steps:
        enabled = True
        with rotating("native") as law:
            before = law.get("Omega")
            for k, torque in enumerate(tau.tolist()):
                law.put(top_torque=torque, top_speed=10.0 - torque / 2000.0)
                if name == "switched" and random.random() < 0.02:
                    enabled = not enabled
                    law.put(enabled=enabled)
                law.go((k + 1) * STEP)
                steps[name].append(law.get("Omega") - before)
                before = law.get("Omega")
    # what is left of a gap of at most 40 rad/s goes in the first step by the share 1 - exp(-0.01)
    assert max(map(abs, steps["switched"])) <= max(map(abs, steps["always"])) + 40.0 * (1.0 - math.exp(-STEP))


def test_switched_off_speed_ref_passes_through() -> None:
    with rotating("native", enabled=False) as law:
        random = np.random.default_rng(3)
        for k in range(50):
            ref = float(random.uniform(-5.0, 15.0))
            law.put(speed_ref=ref, top_torque=float(random.uniform(-2e4, 2e4)))
            law.go((k + 1) * STEP)
            assert law.get("Omega") == ref


def test_a_limit_that_has_held_leaves_nothing_behind() -> None:
    torque = 7589.626471
    with rotating("native", Omega_max=12.0) as law:
        held = 0
        for k in range(4000):
            swing = 20000.0 * math.sin(2.5 * k * STEP) if k < 1000 else 0.0
            law.put(top_torque=torque + swing)
            law.go((k + 1) * STEP)
            held += int(law.get("limit_active"))
            assert abs(law.get("Omega")) <= 12.0
        assert held > 100
        assert law.get("Omega") == pytest.approx(10.0, abs=0.02)


SOFT, LIGHTER, CHANGED = 1000.0, 80000.0, 30.0
"""Damping the law is to show [N m s/rad], weight after a change [N], and when it comes [s]."""
TORQUE = torque_on_bit(PAPER, WEIGHT, 10.0)
RUNNING = {"initial_speed": 10.0, "initial_torque": TORQUE}
REACHED = 10.0 + TORQUE / SOFT
"""Speed asked for with which a drive of that damping turns the string at 10 rad/s [rad/s]."""


def bit_speed(step_size: float, algorithm: str, *components: Component, **inputs: Constant) -> np.ndarray:
    """Return the bit speed from just before the weight changes on, by when what the start left has died away."""
    connections = [Connection("law.Omega", "plant.Omega")]
    connections += [Connection(f"plant.{name}", f"law.{name}") for name in ("top_speed", "top_torque")]
    signals = {"plant.WOB": Step(WEIGHT, LIGHTER, at=CHANGED), **{f"plant.{name}": inputs[name] for name in inputs}}
    system = System(components, connections if len(components) > 1 else (), signals)
    found = simulate(Scenario("run", system, stop_time=45.0, step_size=step_size, method=Method(algorithm)))
    return found["plant.bit_speed"][found.time >= CHANGED - 1.0]


@cache
def error(step_size: float, algorithm: str) -> float:
    """Return how far apart law with plant and the plant alone are, at most [rad/s]."""
    own = {"mode": "own", "P": SOFT, "K": 0.0, "slip": "compensated", "filter_time": 0.0, "handover_time": 0.0}
    law = Component("law", "SoftTorque", {**own, "speed_ref": REACHED, "Omega_max": 1000.0})
    coupled = bit_speed(step_size, algorithm, Component("plant", PLANT, RUNNING), law)
    plant = Component("plant", PLANT, {**RUNNING, "c_a": SOFT})
    return float(np.abs(coupled - bit_speed(step_size, "gauss-seidel", plant, Omega=Constant(REACHED))).max())


def test_without_filters_it_is_the_plant_with_that_damping() -> None:
    """P alone is c_a (Omega - y) = P (r - y), the boundary condition with c_a = P, but for the error of the coupling.

    That is of second order under the implicit algorithm, as with the tracking law.
    """
    sizes = (0.04, 0.02, 0.01)
    assert np.polyfit(np.log(sizes), np.log([error(size, "implicit") for size in sizes]), 1)[0] >= 1.7
    assert error(0.02, "implicit") <= 0.1 * error(0.02, "gauss-seidel")
