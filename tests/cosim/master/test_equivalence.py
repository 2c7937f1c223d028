"""The tracking law without its bit term is the plant with another c_a, so a coupled run has an exact solution.

With c_b = 0 the law turns the top's damping c_a into c_a (1 - c_1), and its reference into the drive speed
(Omega_ref - c_1 r) / (1 - c_1) with Omega_ref = r + T_ref / c_a. The plant alone, its inputs held, is computed without
any coupling at all.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from cosim import Component, Connection, Constant, Method, Result, Scenario, Step, System, simulate
from tests.oracle import OracleParameters
from tests.plant.theory import torque_on_bit

SPEED, WEIGHT, LIGHTER = 10.0, 97347.0, 80000.0
C_A, C_1 = 2000.0, 0.5
TORQUE = torque_on_bit(OracleParameters(), WEIGHT, SPEED)
RUNNING = {"initial_speed": SPEED, "initial_torque": TORQUE}
SIZES = (0.04, 0.02, 0.01, 0.005)
STOP = 20.0


def coupled_run(start: str, step_size: float, method: Method, packaging: str = "native", stop: float = STOP) -> Result:
    law = {"form": "tracking", "c_1": C_1, "c_b": 0.0, "bit_speed_ref": SPEED, "bit_torque_ref": TORQUE}
    components = (
        Component("plant", "DrillstringNeutral", RUNNING if start == "running" else {}),
        Component("law", "DissipativeLaw", {**law, "Omega_max": 1000.0}),
    )
    connections = (Connection("law.Omega", "plant.Omega"), Connection("plant.top_speed", "law.top_speed"))
    system = System(components, connections, {"plant.WOB": Step(WEIGHT, LIGHTER, at=1.0)})
    scenario = Scenario("coupled", system, stop_time=stop, step_size=step_size, method=method)
    return simulate(scenario, packaging=packaging)


def plant_alone(start: str, step_size: float, stop: float = STOP) -> Result:
    omega = (SPEED + TORQUE / C_A - C_1 * SPEED) / (1.0 - C_1)
    parameters = {"c_a": C_A * (1.0 - C_1), **(RUNNING if start == "running" else {})}
    inputs = {"plant.WOB": Step(WEIGHT, LIGHTER, at=1.0), "plant.Omega": Constant(omega)}
    system = System((Component("plant", "DrillstringNeutral", parameters),), (), inputs)
    return simulate(Scenario("alone", system, stop_time=stop, step_size=step_size))


@cache
def error(start: str, step_size: float, algorithm: str) -> float:
    """Return the largest error of the bit speed at communication points, rad/s."""
    found = coupled_run(start, step_size, Method(algorithm))
    return float(np.abs(found["plant.bit_speed"] - plant_alone(start, step_size)["plant.bit_speed"]).max())


def order(start: str, algorithm: str) -> float:
    """Fit the order over the step sizes."""
    errors = [error(start, size, algorithm) for size in SIZES]
    return float(np.polyfit(np.log(SIZES), np.log(errors), 1)[0])


def test_closed_loops_on_straight_lines_are_a_tenth_of_gauss_seidels_error_at_most() -> None:
    assert error("running", 0.02, "implicit") <= 0.1 * error("running", 0.02, "gauss-seidel")


def test_from_the_running_equilibrium_the_implicit_algorithm_is_of_second_order_and_gauss_seidel_of_first() -> None:
    assert order("running", "implicit") >= 1.7
    assert 0.9 <= order("running", "gauss-seidel") <= 1.1


@pytest.mark.slow
def test_from_rest_the_implicit_error_is_below_gauss_seidels_at_every_step_size() -> None:
    """Jumps travel up and down the string and meet the law within steps, where no straight line follows them.

    Each is smeared over a step, so that the order from rest is one; a tolerance finds the jumps (below).
    """
    for size in SIZES:
        assert error("rest", size, "implicit") < 0.5 * error("rest", size, "gauss-seidel")
    assert 0.7 < order("rest", "implicit") < 1.4


@pytest.mark.parametrize("start", ["running", "rest"])
def test_a_tolerance_finds_the_jumps_and_kinks_within_steps(start: str) -> None:
    exact = plant_alone(start, 0.04)
    errors = []
    for tolerance in (1e-2, 1e-3, 1e-4):
        found = coupled_run(start, 0.04, Method("implicit", tolerance=tolerance))
        rows = np.searchsorted(found.time, exact.time)
        assert (found.time[rows] == exact.time).all()
        errors.append(float(np.abs(found["plant.bit_speed"][rows] - exact["plant.bit_speed"]).max()))
    assert errors[2] < 2e-3
    assert errors[2] < 0.5 * errors[0]
    assert found.record["steps"] < 4 * (exact.time.size - 1)


def test_a_step_takes_two_trials_once_the_loop_is_known() -> None:
    found = coupled_run("rest", 0.02, Method("implicit"))
    assert found["coupling.iterations"].max() <= 3
    assert found["coupling.iterations"].mean() <= 2.0
    assert found["plant.Omega"] == pytest.approx(found["law.Omega"], rel=1e-9)
    assert found.record["loops"] == ["plant.Omega -> plant.top_speed -> law.top_speed -> law.Omega -> plant.Omega"]


def test_an_fmu_that_saves_its_state_but_does_not_interpolate_takes_part_at_first_order() -> None:
    """The python packaging holds its inputs: implicit steps are then as good as held values are, and converge."""
    exact = {size: plant_alone("running", size, 3.0)["plant.bit_speed"] for size in (0.02, 0.01)}
    errors = {}
    for algorithm in ("gauss-seidel", "implicit"):
        for size in exact:
            found = coupled_run("running", size, Method(algorithm), "python", 3.0)
            errors[algorithm, size] = float(np.abs(found["plant.bit_speed"] - exact[size]).max())
    assert found["coupling.iterations"].max() <= 3
    for size in exact:
        assert errors["implicit", size] < errors["gauss-seidel", size]
    assert 1.5 < errors["implicit", 0.02] / errors["implicit", 0.01] < 3.0
