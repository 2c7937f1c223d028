"""SciPy's method of lines: the wave equation on a staggered grid, ``solve_ivp`` between the bit's stops and releases.

Torque lives in the middle of each of ``n`` cells, speed at the nodes between them; the bit's inertia takes in the half
cell beside it. The top slides in its damper without inertia, so its speed follows from the torque extrapolated there.
The bit slips until its speed reaches zero, an event, and is then held at rest until the torque on it exceeds the static
torque, another event.

Central differences are of second order where the solution is smooth, but every stop sends a kink up the string, and a
kink disperses: up to 400 cells the error of the period falls by 2.6 for each doubling, by 4 only beyond 800. The steps
are bound by the waves' stability limit, so an explicit method with a wide one (DOP853) and tolerances that disappear
below the grid's error are the fastest that SciPy has; the right-hand side is compiled by numba.
"""

from math import copysign, exp, sqrt

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from .cycle import Slips
from .plant import (
    BIT_DAMPING,
    BIT_INERTIA,
    COULOMB_TORQUE,
    DECAY,
    IMPEDANCE,
    LENGTH,
    LINE_INERTIA,
    OMEGA,
    STATIC_TORQUE,
    STIFFNESS,
    TOP_DAMPING,
)

WAVE_SPEED = sqrt(STIFFNESS / LINE_INERTIA)  # m/s
RELEASE_TORQUE = (1.0 + 1e-9) * STATIC_TORQUE  # N m; at the static torque itself rounding can free and stop for ever
TOLERANCE = 1e-4  # rad/s absolute and relative; far below the error of the grid


@njit(error_model="numpy")
def _derivative(_time, state, cells, direction):
    """Return the rate of change of the state, with the bit slipping in ``direction`` or, if that is 0, at rest.

    State: torque against the rotation over the impedance, of each cell from the top [rad/s], then speed of each node
    below the top [rad/s], the bit's last.
    """
    rate = WAVE_SPEED * cells / LENGTH
    slope = np.empty_like(state)
    above = OMEGA + IMPEDANCE / TOP_DAMPING * (1.5 * state[0] - 0.5 * state[1])
    for i in range(cells):
        slope[i] = rate * (state[cells + i] - above)
        above = state[cells + i]
    for i in range(cells - 1):
        slope[cells + i] = rate * (state[i + 1] - state[i])
    slope[-1] = 0.0
    if direction != 0.0:
        bit_speed = state[-1]
        stribeck = COULOMB_TORQUE + (STATIC_TORQUE - COULOMB_TORQUE) * exp(-DECAY * abs(bit_speed))
        load = IMPEDANCE * state[cells - 1] + BIT_DAMPING * bit_speed + direction * stribeck
        slope[-1] = -load / (BIT_INERTIA + 0.5 * LINE_INERTIA * LENGTH / cells)
    return slope


def _change(_time, state, cells, direction):
    """Return a number that falls through zero where a slip ends or, at rest, where the static torque is exceeded."""
    if direction == 0.0:
        return RELEASE_TORQUE - IMPEDANCE * abs(state[cells - 1])
    return direction * state[-1]


_change.terminal = True
_change.direction = -1.0


def simulate(resolution: int, end_time: float) -> Slips:
    """Simulate from rest.

    Parameters
    ----------
    resolution : int
        Cells of the string.
    end_time : float, s
        Length of the run.

    Returns
    -------
    Slips
        Releases and stops of the completed slips.
    """
    time, direction = 0.0, 0.0
    state = np.zeros(2 * resolution)
    releases, stops = [], []
    options = {"method": "DOP853", "rtol": TOLERANCE, "atol": TOLERANCE, "events": _change, "t_eval": ()}
    while True:
        run = solve_ivp(_derivative, (time, end_time), state, args=(resolution, direction), **options)
        if run.status != 1:
            return Slips(np.array(releases[: len(stops)]), np.array(stops))
        time, state = run.t_events[0][0], run.y_events[0][0]
        stopped = direction != 0.0
        if stopped:
            stops.append(time)
            state[-1], direction = 0.0, 0.0
        if not stopped or IMPEDANCE * abs(state[resolution - 1]) > RELEASE_TORQUE:
            releases.append(time)
            direction = copysign(1.0, -state[resolution - 1])
