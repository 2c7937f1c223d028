"""Numba script: Heun steps that divide the travel time, both waves in ring buffers, Karnopp's clamp at zero speed.

The string is two waves. ``D`` leaves the top, ``U = v - D(t - Gamma)`` leaves the bit, each arrives one travel time
later, and a step of ``Gamma / resolution`` makes both delays whole numbers of steps. The bit obeys

    I_B dv/dt = 2 Z d - (Z + c_b) v - W R_b mu(v) sgn v,    d(t) = D(t - Gamma)

and sticks while ``|2 Z d|`` stays within the static torque. Only slips are recorded, the least a user can ask for.
"""

from math import exp

import numpy as np
from numba import njit

from .cycle import Slips
from .plant import (
    BIT_DAMPING,
    BIT_INERTIA,
    COULOMB_TORQUE,
    DECAY,
    DRIVEN_WAVE,
    IMPEDANCE,
    REFLECTION,
    STATIC_TORQUE,
    TRAVEL_TIME,
)

WAVE_GAIN = 2.0 * IMPEDANCE / BIT_INERTIA  # 1/s
DAMPING_RATE = (IMPEDANCE + BIT_DAMPING) / BIT_INERTIA  # 1/s
COULOMB_RATE = COULOMB_TORQUE / BIT_INERTIA  # rad/s^2
STATIC_RATE = STATIC_TORQUE / BIT_INERTIA  # rad/s^2
FALL_RATE = STATIC_RATE - COULOMB_RATE  # rad/s^2


@njit(fastmath=True, error_model="numpy")
def _acceleration(v, d, direction):
    friction = COULOMB_RATE + FALL_RATE * exp(-DECAY * direction * v)
    return WAVE_GAIN * d - DAMPING_RATE * v - direction * friction


@njit(fastmath=True, error_model="numpy")
def _heun(v, d_start, d_end, step, direction):
    slope = _acceleration(v, d_start, direction)
    predicted = v + step * slope
    return v + 0.5 * step * (slope + _acceleration(predicted, d_end, direction))


@njit(fastmath=True, error_model="numpy")
def _run_clamped(cells, step, steps, interpolate, releases, stops):
    """Fill in the slips of a run whose stops and releases take effect at the ends of steps; return their number."""
    down, up = np.zeros(cells), np.zeros(cells)
    v, d, d_before, direction = 0.0, 0.0, 0.0, 0.0
    slot, count = 0, 0
    for k in range(steps):
        d_next = down[slot]
        if direction == 0.0 and WAVE_GAIN * abs(d) > STATIC_RATE:
            direction = 1.0 if d > 0.0 else -1.0
            late = (d - direction * STATIC_RATE / WAVE_GAIN) / (d - d_before) if interpolate else 0.0
            releases[count] = (k - max(0.0, min(1.0, late))) * step
        v_next = 0.0
        if direction != 0.0:
            v_next = _heun(v, d, d_next, step, direction)
            if v_next * direction <= 0.0:
                stops[count] = (k + v / (v - v_next)) * step if interpolate else (k + 1) * step
                v_next, direction = 0.0, 0.0
                count += 1
        down[slot] = DRIVEN_WAVE - REFLECTION * up[slot]
        up[slot] = v_next - d_next
        slot = slot + 1 if slot + 1 < cells else 0
        d_before, v, d = d, v_next, d_next
    return count


@njit(fastmath=True, error_model="numpy")
def _run_located(cells, step, steps, releases, stops):
    """Fill in the slips of a run that restarts the bit inside the step that frees it; return their number."""
    down, up = np.zeros(cells), np.zeros(cells)
    v, d, direction = 0.0, 0.0, 0.0
    slot, count = 0, 0
    for k in range(steps):
        d_next = down[slot]
        v_next = 0.0
        if direction != 0.0:
            v_next = _heun(v, d, d_next, step, direction)
        elif WAVE_GAIN * abs(d_next) > STATIC_RATE:
            direction = 1.0 if d_next > 0.0 else -1.0
            edge = direction * STATIC_RATE / WAVE_GAIN
            waited = max(0.0, (edge - d) / (d_next - d))
            releases[count] = (k + waited) * step
            v_next = _heun(0.0, edge, d_next, (1.0 - waited) * step, direction)
        if direction != 0.0 and v_next * direction <= 0.0:
            stops[count] = (k + v / (v - v_next)) * step if v != 0.0 else k * step
            v_next, direction = 0.0, 0.0
            count += 1
        down[slot] = DRIVEN_WAVE - REFLECTION * up[slot]
        up[slot] = v_next - d_next
        slot = slot + 1 if slot + 1 < cells else 0
        v, d = v_next, d_next
    return count


def _slips(kernel, resolution, end_time, *options):
    step = TRAVEL_TIME / resolution
    steps = int(end_time / step)
    releases, stops = np.empty(steps + 1), np.empty(steps + 1)
    count = kernel(resolution, step, steps, *options, releases, stops)
    return Slips(releases[:count].copy(), stops[:count].copy())


def simulate(resolution: int, end_time: float, interpolate: bool = False) -> Slips:
    """Simulate from rest with the clamp at the ends of steps.

    Parameters
    ----------
    resolution : int
        Steps in one travel time of the wave (0.372 s).
    end_time : float, s
        Length of the run.
    interpolate : bool
        Report each stop and release where a straight line through the step's ends puts it, rather than at an end.
        The trajectory is the same.

    Returns
    -------
    Slips
        Releases and stops of the completed slips.
    """
    return _slips(_run_clamped, resolution, end_time, interpolate)


def simulate_interpolated(resolution: int, end_time: float) -> Slips:
    """Simulate as ``simulate`` does and interpolate the reported times."""
    return simulate(resolution, end_time, interpolate=True)


def simulate_located(resolution: int, end_time: float) -> Slips:
    """Simulate from rest; a release is located and the rest of its step taken from there.

    Parameters and result are those of ``simulate``.
    """
    return _slips(_run_located, resolution, end_time)
