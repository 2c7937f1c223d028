"""The paper's neutral equation (14) in jitcdde, compiled to C, as an expert of that library would write it.

Written for a set-valued friction torque T, which at rest is whatever holds the bit, (14) is one relation for the sum of
the inertia's and the friction's torque. With ``a = dv/dt + T/I_B`` and ``Psi = Z/I_B`` it reads

    a(t) = Upsilon a(t - 2 Gamma) - Psi v(t) - Psi Upsilon v(t - 2 Gamma) + 2 Psi (c_a/Lambda) Omega(t - Gamma)
    dv/dt = a - T/I_B

``a`` is the derivative of the second component, so its delayed value comes from ``dy``. Three things make it fast:

* Karnopp's zone by ``conditional``: inside, friction cancels ``a`` up to the static torque and the speed left decays.
* The second component grows with time, so its relative tolerance would be void: only the absolute one is set.
* A stop kinks ``a``, and the kink comes back every 2 Gamma: steps end there. So do they at the jumps of the first wave.
"""

import heapq
from contextlib import chdir
from functools import cache
from tempfile import TemporaryDirectory

import numpy as np
import symengine
from chspy import Anchor, interpolate
from jitcdde import dy, jitcdde, t, y
from jitcxde_common import conditional
from scipy.optimize import brentq

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

ROUND_TRIP = 2.0 * TRAVEL_TIME  # s
MEMORY = 1.5 * ROUND_TRIP  # s, of past kept; with exactly the delay, an anchor just at it is freed while in use
WAVE_RATE = IMPEDANCE / BIT_INERTIA  # 1/s, Psi
STATIC_RATE = STATIC_TORQUE / BIT_INERTIA  # rad/s^2
COULOMB_RATE = COULOMB_TORQUE / BIT_INERTIA  # rad/s^2
REST_TIME = 0.05  # s, in which the speed left in Karnopp's zone decays
EDGE = 0.1  # width of the zone's smoothed edge over its half-width; at 0.3 the speed hangs in the edge
ECHOES = 20  # round trips after which a kink is lost among the errors (0.74^20 = 0.2 %)
HALF_WIDTH = symengine.Symbol("half_width")  # rad/s, of Karnopp's zone


def _derivative():
    v, v_delayed, a_delayed = y(0), y(0, t - ROUND_TRIP), dy(1, t - ROUND_TRIP)
    a = REFLECTION * a_delayed - WAVE_RATE * (v + REFLECTION * v_delayed) + 2.0 * WAVE_RATE * DRIVEN_WAVE
    edge = EDGE * HALF_WIDTH
    speed = symengine.Max(v, -v)
    stribeck = COULOMB_RATE + (STATIC_RATE - COULOMB_RATE) * symengine.exp(-DECAY * speed)
    slipping = a - BIT_DAMPING / BIT_INERTIA * v - conditional(v, 0, -1, 1, edge) * stribeck
    sticking = symengine.Max(a - STATIC_RATE, 0) + symengine.Min(a + STATIC_RATE, 0) - v / REST_TIME
    return [conditional(speed, HALF_WIDTH, sticking, slipping, edge), a]


@cache
def _compiled():
    """Derive and compile the equation, once a process; takes a C compiler."""
    integrator = jitcdde(
        _derivative(), delays=[0.0, ROUND_TRIP], max_delay=MEMORY, control_pars=[HALF_WIDTH], verbose=False
    )
    with TemporaryDirectory() as folder, chdir(folder):
        integrator.compile_C(simplify=False)  # builds with setuptools, which would read this project's pyproject.toml
    return integrator


def _start(tolerance):
    """Return the integrator at rest at the time the first wave reaches the bit."""
    integrator = _compiled()
    integrator.purge_past()
    integrator.constant_past([0.0, 0.0], time=TRAVEL_TIME)
    integrator.set_parameters(tolerance)
    integrator.set_integration_parameters(
        rtol=0.0, atol=tolerance, first_step=1e-3, max_step=TRAVEL_TIME / 4.0, min_step=1e-15
    )
    integrator.adjust_diff(1e-9)
    return integrator


def _steps(integrator, target):
    """Step to a target exactly, which ``integrate`` overshoots; yield after each accepted step."""
    core = integrator.DDE
    while core.get_t() < target - 1e-9:
        if integrator.try_single_step(min(integrator.dt, target - core.get_t())):
            core.accept_step()
            yield core


def _crossing(core, speed):
    last_step = [Anchor(*anchor) for anchor in core.get_full_state()[-2:]]
    times = [anchor.time for anchor in last_step]
    return brentq(lambda time: interpolate(time, 0, last_step) - speed, *times, xtol=1e-12)


def simulate(resolution: float, end_time: float) -> Slips:
    """Simulate from rest.

    Parameters
    ----------
    resolution : float
        Absolute tolerance of a step [rad/s] and half-width of Karnopp's zone [rad/s].
    end_time : float, s
        Length of the run.

    Returns
    -------
    Slips
        Releases and stops of the completed slips: crossings of a speed just outside Karnopp's zone.
    """
    integrator = _start(resolution)
    threshold = 1.5 * resolution
    jumps = [TRAVEL_TIME + k * ROUND_TRIP for k in range(1, ECHOES)]
    targets = [*(jump for jump in jumps if jump < end_time), end_time]
    releases, stops, slipping = [], [], False
    while targets:
        target = heapq.heappop(targets)
        for core in _steps(integrator, target):
            if (core.get_current_state()[0] > threshold) == slipping:
                continue
            (stops if slipping else releases).append(_crossing(core, threshold))
            if slipping:
                echoes = (stops[-1] + k * ROUND_TRIP for k in range(1, ECHOES))
                for echo in (echo for echo in echoes if echo < end_time):
                    heapq.heappush(targets, echo)
            slipping = not slipping
            core.forget(MEMORY)
        if target in jumps:
            integrator.adjust_diff(1e-6)
    return Slips(np.array(releases[: len(stops)]), np.array(stops))
