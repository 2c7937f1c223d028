"""The characteristic function of uniform rotation, and where in the plane its zeros can lie.

About a running equilibrium eq. (14) has solutions exp(s t) for the zeros s of

    h(s) = a + Z - Upsilon exp(-2 Gamma s) (a - Z),    a = I_B s + T',

T' being the slope of the torque on bit. |a - Z| < |a + Z| if and only if Re a > 0. So a zero with Re a < 0 has
|Upsilon exp(-2 Gamma s)| < 1, and one with Re a > 0 the contrary: all zeros lie in the strip between

    chain = ln |Upsilon| / (2 Gamma)    and    local = -T' / I_B,

on whichever side of each other these are, and far from the real axis they draw near to the chain.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log, pi

import numpy as np

from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import ComplexArray
from ..numerics.root_count import zeros_inside
from .linear_neutral import LinearNeutral


@dataclass(frozen=True)
class Characteristic:
    """h and what is known of its zeros.

    Attributes
    ----------
    parameters : DrillstringParameters
        The string.
    slope : float
        T' [N m s/rad].
    """

    parameters: DrillstringParameters
    slope: float

    @property
    def chain(self) -> float:
        """Real part ln |Upsilon| / (2 Gamma) that the zeros tend to [1/s]; minus infinity without reflection."""
        reflection = abs(self.parameters.reflection)
        return log(reflection) / (2.0 * self.parameters.travel_time) if reflection > 0.0 else -inf

    @property
    def local(self) -> float:
        """Growth rate -T' / I_B of a bit that turns alone [1/s]: with the chain, the strip of all zeros."""
        return -self.slope / self.parameters.I_B

    def value(self, s: ComplexArray) -> ComplexArray:
        """Return h [N m s/rad]."""
        a = self.parameters.I_B * s + self.slope
        echo = self._echo(s)
        return a + self.parameters.impedance - echo * (a - self.parameters.impedance)

    def derivative(self, s: ComplexArray) -> ComplexArray:
        """Return dh/ds."""
        p, echo = self.parameters, self._echo(s)
        return p.I_B * (1.0 - echo) + 2.0 * p.travel_time * echo * (p.I_B * s + self.slope - p.impedance)

    def _echo(self, s: ComplexArray) -> ComplexArray:
        """Return Upsilon exp(-2 Gamma s)."""
        return np.asarray(self.parameters.reflection * np.exp(-2.0 * self.parameters.travel_time * s), np.complex128)

    def system(self) -> LinearNeutral:
        """Return the linearised eq. (14) itself, with v as the state and 2 Gamma as the unit of delay."""
        p = self.parameters
        E = [[[p.reflection]]]
        A = [[[-(p.impedance + self.slope) / p.I_B]], [[-p.reflection * (p.impedance - self.slope) / p.I_B]]]
        return LinearNeutral(2.0 * p.travel_time, np.array(E), np.array(A))

    def refined(self, s: ComplexArray) -> ComplexArray:
        """Return what Newton's method makes of approximate zeros; those it does not settle are left out."""
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS - 1):
                s = s - self.value(s) / self.derivative(s)
            step = self.value(s) / self.derivative(s)
            settled = np.isfinite(s) & (np.abs(step) <= SETTLED * (1.0 + np.abs(s)))
        return (s - step)[settled]

    def count_right_of(self, abscissa: float) -> int:
        """Return the number of zeros with a real part above `abscissa` [1/s], by the argument principle.

        There |a + Z| = |Upsilon exp(-2 Gamma s)| |a - Z| bounds |a|, and so the contour.

        Raises
        ------
        ValueError
            `abscissa` is not to the right of the chain, so that there may be zeros without number.
        ArithmeticError
            A zero has, to rounding, the real part `abscissa`.
        """
        if abscissa <= self.chain:
            raise ValueError(f"abscissa is {abscissa} 1/s; expected a value above that of the chain, {self.chain} 1/s")
        p = self.parameters
        ratio = abs(p.reflection) * np.exp(-2.0 * p.travel_time * abscissa)
        reach = 1.01 * (p.impedance * (1.0 + ratio) / (1.0 - ratio) + abs(self.slope)) / p.I_B
        if abscissa >= reach:
            return 0
        return self.count_in(abscissa, reach, reach)

    def count_in(self, left: float, right: float, height: float) -> int:
        """Return the number of zeros with real parts in (left, right) and imaginary parts in (-height, height)."""
        spacing = min(0.2 / self.parameters.travel_time, 0.2 * (right - left))
        return zeros_inside(self.value, (left, right), (-height, height), spacing)

    def none_beyond(self, height: float, abscissa: float) -> bool:
        """Return whether no zero with |Im s| >= height > 0 has a real part of at least `abscissa` [1/s], chain < local.

        On a zero x = Re s is chain + g / (4 Gamma), with g the logarithm of |(a - Z) / (a + Z)|^2, which falls with
        |Im a|. So it is enough that this is below x for all x from `abscissa` to local, at the height itself. As it
        changes by 1 / (2 Gamma height) per unit of x at most, x can be taken further each time by what it is short of.
        """
        p, x = self.parameters, abscissa
        steepest = 1.0 + 1.0 / (2.0 * p.travel_time * height)
        rise = (p.I_B * height) ** 2
        while x < self.local:
            a = p.I_B * x + self.slope
            g = log(((a - p.impedance) ** 2 + rise) / ((a + p.impedance) ** 2 + rise))
            short = x - self.chain - g / (4.0 * p.travel_time)
            if short <= 0.0 or x + short / steepest == x:
                return False
            x += short / steepest
        return True

    def between_chain_zeros(self, number: int) -> float:
        """Return a height [1/s] midway between far zeros, whose phases are those of the chain; number >= 1."""
        offset = 0.0 if self.parameters.reflection > 0.0 else 0.5
        return (number + offset - 0.5) * pi / self.parameters.travel_time


NEWTON_STEPS = 12
SETTLED = 1e-12
