"""Delay that a law of waves bears: what the top of the string reflects when the drive comes late."""

from __future__ import annotations

from math import inf

from ..numerics.trigonometry import sine_and_cosine
from .virtual_drive import Gains

HIGHEST, PER_OCTAVE = 1000.0, 48
"""Frequencies looked at: up to this [rad/s], so many in a doubling."""
LOWEST = 1e-3
"""The lowest frequency looked at [rad/s]."""
ROUNDING = 1e-12
MOST_QUARTERS = 128
"""Of a delay, up to which a filter time is looked for."""


def reflection(
    impedance: float, slip: float, gains: Gains, filter_time: float, delay: float, frequency: float
) -> float:
    """Return the size of the reflection at the top, Upsilon + (R - Upsilon) F exp(-j omega d).

    Parameters
    ----------
    impedance, slip : float
        Z of the string and c_a of the plant [N m s/rad].
    gains : Gains
        The string is to meet X = P + K / s + J_v s at its top, R = (Z - X) / (Z + X).
    filter_time, delay : float
        T_f of F = 1 / (1 + j omega T_f), and d of the drive: its delay and its lag [s].
    frequency : float
        omega [rad/s], above 0.
    """
    bare = (impedance - slip) / (impedance + slip)
    met = complex(gains.damping, gains.inertia * frequency - gains.stiffness / frequency)
    meant = (impedance - met) / (impedance + met)
    turned = sine_and_cosine(frequency * delay)
    late = complex(turned.cosine, -turned.sine) / complex(1.0, frequency * filter_time)
    return abs(bare + (meant - bare) * late)


def bears(impedance: float, slip: float, gains: Gains, filter_time: float, delay: float) -> bool:
    """Return whether no frequency comes back from the top greater than it went there."""
    frequency = LOWEST
    while frequency <= HIGHEST:
        if reflection(impedance, slip, gains, filter_time, delay, frequency) > 1.0 + ROUNDING:
            return False
        frequency = frequency * (1.0 + 0.6931471805599453 / PER_OCTAVE)
    return True


def least_filter_time(impedance: float, slip: float, gains: Gains, delay: float) -> float:
    """Return the least filter time with which a delay is borne, in quarters of it [s]; inf if 32 times it does not do.

    With the start values of the plant it is not above 2 d for soft torque and impedance matching; the stiffer the bare
    drive (c_a), the longer.
    """
    for quarters in range(MOST_QUARTERS + 1):
        if bears(impedance, slip, gains, 0.25 * quarters * delay, delay):
            return 0.25 * quarters * delay
    return inf
