"""Bit speed and torque from the top: exact where the string is as assumed, and wrong by what is known where not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest

from tests.plant.drive import DAMPED, PLANT, Drive
from tests.plant.programs import PAPER

pytestmark = pytest.mark.slow

AWAY, Z = PAPER.travel_time, PAPER.impedance
STOP = 40.0


def observed(
    step: float, string: Mapping[str, float] | None = None, known: Mapping[str, float] | None = None, noise: float = 0.0
) -> dict[str, np.ndarray]:
    """Return what an observer says of a string in stick-slip from rest, and what was so a travel time before.

    Parameters
    ----------
    string : mapping of str to float, optional
        Parameters of another plant, with damping along it if there is a beta.
    known : mapping of str to float, optional
        What the observer knows of it, other than what is so.
    noise : float
        Standard deviation of the measured torque [N m].
    """
    random = np.random.default_rng(1)
    given = dict(string or {})
    rows: list[dict[str, float]] = []
    model = DAMPED if "beta" in given else PLANT
    with Drive(model, given) as plant, Drive(model, given) as truth, Drive("BitSpeedObserver", known or {}) as observer:
        for k in range(1, int(STOP / step) + 1):
            plant.go(k * step)
            torque = plant.get("top_torque") + noise * random.normal()
            observer.put(top_speed=plant.get("top_speed"), top_torque=torque)
            observer.go(k * step)
            row = observer.named()
            if k * step - AWAY > truth.time:
                truth.go(k * step - AWAY)
            rows.append({**row, "speed": truth.get("bit_speed"), "torque": truth.get("bit_torque"), "time": k * step})
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


@cache
def exact() -> dict[str, np.ndarray]:
    return observed(2.0 * AWAY / 800)


def rms(found: dict[str, np.ndarray]) -> float:
    """Return the root of the mean square error of the bit speed after 20 s, jumps left out [rad/s]."""
    late = found["time"] > 20.0
    error = (found["bit_speed"] - found["speed"])[late]
    return float(np.sqrt(np.mean(error**2)))


def test_it_is_exact_where_a_step_divides_the_travel_time() -> None:
    """Rounding in times and waves alone is left, 1e-16 of speeds that change by 1e2 rad/s^2."""
    found = exact()
    valid = found["valid"] == 1
    assert np.abs(found["bit_speed"] - found["speed"])[valid].max() <= 1e-8
    assert valid[found["time"] > 20.0].mean() > 0.9


def test_it_is_valid_not_before_the_history_is_known() -> None:
    found = exact()
    assert not found["valid"][found["time"] < 2.0 * AWAY * (1.0 - 1e-9)].any()
    assert found["valid"][found["time"] > 2.0 * AWAY][:100].any()


def test_with_steps_of_ten_milliseconds_it_is_good_to_a_hundredth() -> None:
    assert rms(observed(0.01)) <= 0.01


def test_torque_on_bit_is_that_of_the_plant_but_for_the_filter() -> None:
    found = exact()
    late = (found["time"] > 20.0) & (found["valid"] == 1)
    error = np.abs(found["bit_torque"] - found["torque"])[late]
    # 20 ms late, the torque of a string that is wound up by some 2500 N m/s; more where it jumps, at stops and releases
    assert np.median(error) < 2.0 * 0.02 * 2500.0
    assert np.mean(error < 500.0) > 0.9


def test_what_is_known_wrongly_makes_it_wrong_by_what_is_documented() -> None:
    stiffer = observed(0.01, known={"I": PAPER.I * 1.05, "G": PAPER.G * 1.05, "L": PAPER.L})
    longer = observed(0.01, known={"L": PAPER.L * 1.01})
    damped = observed(0.01, string={"beta": 0.05})
    assert rms(stiffer) == pytest.approx(0.34, abs=0.07)
    assert rms(longer) == pytest.approx(0.075, abs=0.03)
    assert rms(damped) == pytest.approx(0.24, abs=0.05)


def test_noise_of_the_torque_comes_through_divided_by_the_impedance() -> None:
    sigma = 150.0
    quiet, noisy = observed(0.01), observed(0.01, noise=sigma, known={"jump": 10.0})
    late = quiet["time"] > 20.0
    extra = float(np.std((noisy["bit_speed"] - quiet["bit_speed"])[late]))
    # two independent values, each half of sigma / Z; one of them interpolated between two samples
    assert 0.8 * sigma / (math.sqrt(2.0) * Z) < extra < 1.02 * sigma / (math.sqrt(2.0) * Z)
    assert noisy["valid"][late].all()


@pytest.mark.parametrize("packaging", ["native", "python"])
def test_memory_is_bounded_however_short_the_steps(packaging: str) -> None:
    with Drive("BitSpeedObserver", {"L": 200.0}, packaging) as observer:
        sizes: list[int] = []
        for k in range(3000):
            observer.put(top_speed=5.0 + math.sin(0.02 * k))
            observer.go((k + 1) * 1e-4)
            if k % 500 == 499:
                sizes.append(len(observer.serialized()))
        assert max(sizes) < 200_000
        found = observer.get("bit_speed")
        assert math.isfinite(found)
