"""The bit equation integrated over one piece of slip.

    I_B dv/dt = 2 Z D(t - Gamma) - (Z + c_b) v - W R_b mu_b(v) sgn v

The speed is the quartic that satisfies it at the four Lobatto points of the piece.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..numerics.collocation import NODES, WEIGHTS, Inner, Slopes, antiderivative, correction, values
from ..numerics.quartic import THIRD, ZERO, Quartic, value
from .clock import Clock
from .friction import Friction
from .parameters import DrillstringParameters

GREATEST_STIFFNESS = 0.5
"""A piece is too rough if its slope depends on the speed more strongly."""

TRUNCATION = 1e-6
"""So is one whose speed a quartic does not follow closer, as far as its last coefficient tells, on the default grid
[rad/s]. The error is about a thousandth of it."""

LEAST_TRUNCATION = 1e-10
MOST_TRUNCATION = 0.1
"""Bounds to which this falls on fine grids and rises on coarse ones, as the sixth power of the block."""

GLANCE = 0.1
"""Work of finding at its begin that a piece is too rough, in blocks: see `models.plant.work`."""

COLLOCATION = 0.35
"""Work of a collocation beside the steps of Newton's method."""

NEWTON_WORK = 0.15
"""Work of one of them."""

NEWTON_STEPS = 12
"""Most Newton steps of a piece; two are usual."""

NEWTON_LIMIT = 3e-6
"""Correction after which no further step is taken, as the next would be about its square, on the default grid; it
changes as the square of the block [rad/s]."""


@dataclass(frozen=True)
class BitLaw:
    """Constants of the bit equation, derived once from the parameters."""

    twice_impedance: float
    damping: float  # Z + c_b
    viscosity: float  # c_b
    inertia: float
    friction: Friction  # at the lever R_b

    @classmethod
    def of(cls, parameters: DrillstringParameters) -> BitLaw:
        """Derive the constants."""
        impedance = parameters.impedance
        return cls(
            twice_impedance=2.0 * impedance,
            damping=impedance + parameters.c_b,
            viscosity=parameters.c_b,
            inertia=parameters.I_B,
            friction=Friction.of(parameters, parameters.R_b),
        )


class Accuracy(NamedTuple):
    """Accuracy asked of a piece.

    Attributes
    ----------
    truncation : float
        Truncation [rad/s] from which on a piece is too rough.
    newton : float
        Correction [rad/s] after which Newton's method ends.
    """

    truncation: float
    newton: float

    @classmethod
    def on(cls, clock: Clock) -> Accuracy:
        """Return what is asked on a grid."""
        square = clock.coarseness * clock.coarseness
        truncation = TRUNCATION * (square * square * square)
        return cls(min(max(truncation, LEAST_TRUNCATION), MOST_TRUNCATION), NEWTON_LIMIT * square)


class Slip(NamedTuple):
    """A piece of slip.

    Attributes
    ----------
    speed : Quartic
        Bit speed over the piece [rad/s].
    power : float
        Integral of bit_torque times bit_speed over the piece, per unit of x [W].
    roughness : float
        How hard the speed is to follow; a piece above 1 is to be halved.
    work : float
        What it took, in blocks.
    """

    speed: Quartic
    power: float
    roughness: float
    work: float


def collocate(
    law: BitLaw,
    accuracy: Accuracy,
    direction: int,
    duration: float,
    start: float,
    incident: Quartic,
    wob: tuple[float, float],
    last_try: bool,
) -> Slip:
    """Return the slip over a piece, by Newton's method from a friction that changes as at the begin.

    Parameters
    ----------
    law : BitLaw
        Friction and inertia of the bit.
    accuracy : Accuracy
        What is asked of the piece.
    direction : int
        1 or -1, in which the bit slips.
    duration : float
        Of the piece [s].
    start : float
        Bit speed at its begin [rad/s].
    incident : Quartic
        D(t - Gamma) on the piece [rad/s].
    wob : (float, float)
        Weight on bit at its begin, and its rise over the piece [N].
    last_try : bool
        The piece will not be halved again: it is integrated even where its begin shows that it is too rough.
    """
    drive = tuple(law.twice_impedance * value(incident, node) for node in NODES)
    weight = tuple(wob[0] + node * wob[1] for node in NODES)
    piece = _Piece(law, direction, duration / law.inertia, drive, weight)
    g0, j0, dry0, _ = piece.slope(0, start)
    roughness = abs(j0) / GREATEST_STIFFNESS
    if roughness > 1.0 and not last_try:
        return Slip(ZERO, 0.0, roughness, GLANCE)
    if start == 0.0 and g0 * direction < 0.0:
        g0 = 0.0  # by rounding: at a release the friction is overcome
    push = piece.scale * law.twice_impedance
    bend = 0.5 * (j0 * g0 + push * incident[1])
    thrust = (THIRD * push * incident[2], 0.25 * push * incident[3], 0.2 * push * incident[4])
    v1, v2, v3 = (start + x * (g0 + x * (bend + x * (thrust[0] + x * (thrust[1] + x * thrust[2])))) for x in NODES[1:])
    speed, slope, jacobian, dry, steps = _solve(piece, accuracy.newton, (start, g0, dry0), (v1, v2, v3))
    turning = antiderivative(start, slope)
    stiffest = max(abs(j0), abs(jacobian[0]), abs(jacobian[1]), abs(jacobian[2]))
    truncation = abs(turning[4]) * (stiffest + law.friction.rate * abs(speed[3] - start))
    roughness = max(stiffest / GREATEST_STIFFNESS, truncation / accuracy.truncation)
    return Slip(turning, _power(law, speed, dry), roughness, COLLOCATION + NEWTON_WORK * steps)


class _Piece(NamedTuple):
    """Constants of all iterations: drive [N m] and weight [N] at the four points; the scale is h / I_B."""

    law: BitLaw
    direction: int
    scale: float
    drive: tuple[float, ...]
    weight: tuple[float, ...]

    def slope(self, i: int, speed: float) -> tuple[float, float, float, float]:
        """Return at a point dv/dx and its derivative by the speed, and the dry friction [N m] and its own."""
        law = self.law
        _, friction, dry_slope = law.friction.at(self.weight[i], self.direction * speed)
        dry = friction * self.direction
        slope = self.scale * (self.drive[i] - law.damping * speed - dry)
        return slope, self.scale * (-dry_slope - law.damping), dry, dry_slope


def _solve(
    piece: _Piece, limit: float, begin: tuple[float, float, float], guess: Inner
) -> tuple[Slopes, Slopes, Inner, Slopes, int]:
    """Solve the equations of collocation from a guess of the three speeds; what holds at the begin is given.

    Returns the speeds, slopes, Jacobian and dry friction, and the steps taken.
    """
    v0, g0, f0 = begin
    v1, v2, v3 = guess
    g1 = g2 = g3 = j1 = j2 = j3 = f1 = f2 = f3 = 0.0
    steps = 0
    while steps < NEWTON_STEPS:
        steps += 1
        g1, j1, f1, s1 = piece.slope(1, v1)
        g2, j2, f2, s2 = piece.slope(2, v2)
        g3, j3, f3, s3 = piece.slope(3, v3)
        w1, w2, w3 = values(v0, (g0, g1, g2, g3))
        d1, d2, d3 = correction((w1 - v1, w2 - v2, w3 - v3), (j1, j2, j3))
        v1, v2, v3 = v1 + d1, v2 + d2, v3 + d3
        g1, g2, g3 = g1 + j1 * d1, g2 + j2 * d2, g3 + j3 * d3
        f1, f2, f3 = f1 + s1 * d1, f2 + s2 * d2, f3 + s3 * d3
        if abs(d1) <= limit and abs(d2) <= limit and abs(d3) <= limit:
            break
    return (v0, v1, v2, v3), (g0, g1, g2, g3), (j1, j2, j3), (f0, f1, f2, f3), steps


def _power(law: BitLaw, speed: Slopes, dry: Slopes) -> float:
    """Return the integral of torque times speed over the piece, per unit of x [W]."""
    total = 0.0
    for i in range(4):
        total = total + WEIGHTS[i] * ((law.viscosity * speed[i] + dry[i]) * speed[i])
    return total
