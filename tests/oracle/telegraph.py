"""The damped string without dry friction in closed form: the telegraph equation by its Laplace transform.

Eq. (1) for a string at rest is, transformed, G J theta'' = (I s^2 + beta s) theta. With the drive on a ramp from rest
and the boundary conditions (2), the bit with viscous damping alone or held, speed and torque at any depth are quotients
of exponentials, whose inverse mpmath computes (de Hoog's method).
"""

from __future__ import annotations

from typing import Any

import mpmath as mp

from tests.oracle.plant import OracleParameters

DIGITS = 45
DEGREE = 110
"""With 60 terms the kinks of a weakly damped string leave errors of 3e-5 rad/s, with these less than 1e-7."""


class Telegraph:
    """A string at rest whose drive speed grows steadily.

    Parameters
    ----------
    parameters : OracleParameters
        The string.
    beta : float
        Damping per unit length [N s/rad].
    slope : float
        Of the drive speed [rad/s^2].
    held : bool
        The bit does not turn; otherwise it turns without dry friction.
    """

    def __init__(self, parameters: OracleParameters, beta: float, slope: float, *, held: bool = False) -> None:
        self.parameters, self.beta, self.slope, self.held = parameters, beta, slope, held

    def _waves(self, s: Any, depth: float) -> tuple[Any, Any, Any]:
        """Return the waves down and up at a depth, and the torque of a speed, all transformed."""
        p = self.parameters
        shear = mp.mpf(p.G) * p.J
        per_length = mp.sqrt((p.I * s * s + self.beta * s) / shear)
        impedance = shear * per_length / s
        bit = p.I_B * s + p.c_b
        echo = -1 if self.held else (impedance - bit) / (impedance + bit)
        echo = echo * mp.exp(-2 * per_length * p.L)
        down = p.c_a * self.slope / s**2 / (p.c_a * (1 + echo) + impedance * (1 - echo))
        return down * mp.exp(-per_length * depth), echo * down * mp.exp(per_length * depth), impedance

    def speed(self, depth: float, time: float) -> float:
        """Return the speed at a depth [m] and a time [s], in rad/s."""
        with mp.workdps(DIGITS):

            def transformed(s: Any) -> Any:
                down, up, _ = self._waves(s, depth)
                return down + up

            return float(mp.invertlaplace(transformed, time, method="dehoog", degree=DEGREE))

    def torque(self, depth: float, time: float) -> float:
        """Return the torque the string transmits at a depth [m] and a time [s], in N m."""
        with mp.workdps(DIGITS):

            def transformed(s: Any) -> Any:
                down, up, impedance = self._waves(s, depth)
                return impedance * (down - up)

            return float(mp.invertlaplace(transformed, time, method="dehoog", degree=DEGREE))

    def twist(self, depth: float, time: float) -> float:
        """Return by how much the top is ahead of a depth [m] at a time [s], in rad."""
        with mp.workdps(DIGITS):

            def transformed(s: Any) -> Any:
                down, up, _ = self._waves(s, 0.0)
                down_there, up_there, _ = self._waves(s, depth)
                return (down + up - down_there - up_there) / s

            return float(mp.invertlaplace(transformed, time, method="dehoog", degree=DEGREE))
