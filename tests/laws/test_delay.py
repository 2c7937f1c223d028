"""What delay a law of waves bears, against frequency responses by NumPy and the rule of twice the delay."""

from __future__ import annotations

import math

import numpy as np
import pytest

from models.controllers.delay import bears, least_filter_time, reflection
from models.controllers.virtual_drive import Gains, TopOfString, soft_torque

STRING = TopOfString()
Z, C_A = STRING.impedance, STRING.c_a


def response(gains: Gains, filter_time: float, delay: float, frequency: np.ndarray) -> np.ndarray:
    """Return the reflection at the top by complex arithmetic of NumPy."""
    s = 1j * frequency
    met = gains.damping + gains.stiffness / s + gains.inertia * s
    bare, meant = (Z - C_A) / (Z + C_A), (Z - met) / (Z + met)
    return np.abs(bare + (meant - bare) * np.exp(-s * delay) / (1 + s * filter_time))


@pytest.mark.parametrize("gains", [soft_torque(STRING), Gains(300.0, 80.0, 40.0)])
def test_reflection_is_that_of_the_frequency_response(gains: Gains) -> None:
    frequency = np.geomspace(1e-2, 500.0, 200)
    found = [reflection(Z, C_A, gains, 0.04, 0.02, w) for w in frequency.tolist()]
    assert found == pytest.approx(response(gains, 0.04, 0.02, frequency).tolist(), abs=1e-12)


@pytest.mark.parametrize("ratio", [1.0, 1.5])
@pytest.mark.parametrize("delay", [0.005, 0.02, 0.1])
def test_a_filter_of_twice_the_delay_is_enough_and_of_half_of_it_is_not(ratio: float, delay: float) -> None:
    gains = soft_torque(STRING, ratio)
    assert bears(Z, C_A, gains, 2.0 * delay, delay)
    assert not bears(Z, C_A, gains, 0.5 * delay, delay)
    least = least_filter_time(Z, C_A, gains, delay)
    assert 0.5 * delay < least <= 2.0 * delay
    assert response(gains, least, delay, np.geomspace(1e-2, 1e3, 5000)).max() <= 1.0 + 1e-4


def test_a_stiffer_drive_needs_more_and_no_delay_needs_nothing() -> None:
    gains = soft_torque(STRING)
    assert least_filter_time(Z, 5.0 * C_A, gains, 0.02) > 2.0 * 0.02
    assert least_filter_time(Z, C_A, gains, 0.0) == 0.0


def test_what_amplifies_whatever_is_filtered_has_no_filter_time() -> None:
    assert least_filter_time(Z, 1e9, soft_torque(STRING), 1.0) == math.inf
