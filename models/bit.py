"""The bit: the down-going wave arrives, dry friction holds or drags, the up-going wave leaves.

    I_B dv/dt = 2 Z D(t - Gamma) - (Z + c_b) v - W R_b mu_b(v) sgn v
    U_b(t)    = v(t) - D(t - Gamma)

At v = 0 the dry friction is any torque up to W R_b mu_sb: the bit stays stuck while |2 Z D(t - Gamma)| does not exceed it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from models.clock import SNAP, Clock, Ramp
from models.cubic import NONE, ZERO, Cubic, extremes, first_positive, hermite, integral, restrict, subtract, value
from models.delay_line import DelayLine
from models.exponential import exponential
from models.parameters import DrillstringParameters

SHORTEST_SLIP = 1e-9
"""A release that would stop again within this part of a piece is none: the bit stays stuck."""

ROOT_STEPS = 6
"""Newton steps that carry a stop from the interpolant to the integrator's own zero."""


@dataclass(frozen=True)
class BitLaw:
    """Constants of the bit equation, derived once from the parameters."""

    twice_impedance: float
    damping: float  # Z + c_b
    viscosity: float  # c_b
    inertia: float
    coulomb: float  # R_b mu_cb
    excess: float  # R_b (mu_sb - mu_cb)
    static: float  # R_b mu_sb
    rate: float  # gamma_b / v_f

    @classmethod
    def of(cls, parameters: DrillstringParameters) -> BitLaw:
        """Derive the constants."""
        impedance = parameters.impedance
        return cls(
            twice_impedance=2.0 * impedance,
            damping=impedance + parameters.c_b,
            viscosity=parameters.c_b,
            inertia=parameters.I_B,
            coulomb=parameters.R_b * parameters.mu_cb,
            excess=parameters.R_b * (parameters.mu_sb - parameters.mu_cb),
            static=parameters.R_b * parameters.mu_sb,
            rate=parameters.gamma_b / parameters.v_f,
        )

    def dry(self, weight: float, direction: int, speed: float) -> float:
        """Return the dry friction torque of a slip in `direction` (1 or -1), continued smoothly through rest [N m]."""
        return weight * (self.coulomb + self.excess * exponential(-self.rate * (direction * speed))) * direction


class Bit:
    """The bit boundary condition, always one piece ahead: the piece that holds the present.

    Attributes
    ----------
    cell, begin, end : int, float, float
        The piece: its cell and its fractions of the cell.
    direction : int
        1 or -1 while the bit slips that way, 0 while it is stuck.
    arriving, turning : Cubic
        D(t - Gamma) and v(t) on the piece [rad/s].
    speed : float
        Bit speed at `begin` [rad/s].
    pressure : Ramp
        The weight on bit as it was set [N].
    weight, weight_rise : float
        Weight on bit at `begin` and its rise over the piece [N].
    stops : bool
        The piece ends because the bit comes to rest there.
    releases : int
        Direction in which the bit breaks loose at the end of the piece, 0 if it does not.
    arrived : bool
        The last piece ended at rest, and it is not yet decided whether the bit sticks.
    angle, loss, stuck : float
        Angle turned [rad], energy lost [J], time stuck [s] up to `begin`.
    """

    __slots__ = (
        "angle", "arrived", "arriving", "begin", "cell", "clock", "direction", "end", "incoming", "last_release",
        "last_stop", "law", "loss", "pressure", "releases", "slips", "speed", "stops", "stuck", "turning", "weight",
        "weight_rise",
    )  # fmt: skip

    def __init__(self, law: BitLaw, clock: Clock, speed: float, pressure: Ramp) -> None:
        self.law = law
        self.clock = clock
        self.cell = 0
        self.begin = self.end = 0.0
        self.direction = 1 if speed > 0.0 else -1 if speed < 0.0 else 0
        self.arriving = self.turning = ZERO
        self.incoming = (0.0, 0.0, ZERO)
        self.speed = speed
        self.pressure = pressure
        self.weight = self.weight_rise = 0.0
        self.stops = self.arrived = False
        self.releases = 0
        self.angle = self.loss = self.stuck = 0.0
        self.last_stop = self.last_release = clock.start
        self.slips = 0

    def open(self, down: DelayLine) -> None:
        """Take up the next piece: to the end of the wave that arrives, or to the first stop or release in it."""
        if self.begin >= self.incoming[1]:
            self.incoming = down.pop()
            self.begin = self.incoming[0]
        self.end = self.incoming[1]
        first, last, wave = self.incoming
        self.arriving = restrict(wave, (self.begin - first) / (last - first), 1.0)
        self.weight, self.weight_rise = self.pressure.over(self.clock, self.cell, self.begin, self.end)
        self.stops = False
        if self.direction == 0:
            self._rest()
        else:
            self._slip()
        self.arrived = False

    def close(self, up: DelayLine) -> None:
        """Send the wave of the piece up the string and go to its end."""
        duration = (self.end - self.begin) * self.clock.cell
        if self.direction == 0:
            self.stuck += duration
        else:
            self.angle += duration * integral(self.turning, 1.0)
            self.loss += duration * self.power_integral(1.0)
            self.speed = self.turning[0] + self.turning[1] + self.turning[2] + self.turning[3]
        up.push(self.begin, self.end, subtract(self.turning, self.arriving))
        if self.stops:
            self.speed = 0.0
            self.direction = 0
            self.arrived = True
        self.begin = self.end
        if self.end >= 1.0:
            self.cell += 1
            self.begin = 0.0
            self.incoming = (0.0, 0.0, ZERO)

    def cut(self, fraction: float, up: DelayLine) -> None:
        """End the piece at a fraction of the cell inside it, because weight or friction change; a new one is to be opened."""
        if fraction - self.begin > SNAP:
            if self.end - fraction > SNAP:
                self._shorten((fraction - self.begin) / (self.end - self.begin), fraction)
                self.stops = False
                self.releases = 0
            self.close(up)

    def torque(self, x: float) -> float:
        """Return the torque on bit at x of the piece; the reaction of the rock while the bit is stuck [N m]."""
        if self.direction == 0:
            return self.law.twice_impedance * value(self.arriving, x)
        speed = value(self.turning, x)
        return self.law.viscosity * speed + self.law.dry(self.weight + x * self.weight_rise, self.direction, speed)

    def power_integral(self, x: float) -> float:
        """Return the integral of bit_torque times bit_speed from 0 to x of the piece, per unit of x [W] (Simpson)."""
        if self.direction == 0:
            return 0.0
        middle = 0.5 * x
        begin = self.torque(0.0) * self.turning[0]
        centre = self.torque(middle) * value(self.turning, middle)
        end = self.torque(x) * value(self.turning, x)
        return x * (0.16666666666666666 * (begin + 4.0 * centre + end))

    def extremes(self, x0: float, x1: float) -> tuple[float, float]:
        """Return the least and greatest bit speed between x0 and x1 of the piece [rad/s]."""
        if self.direction == 0:
            return 0.0, 0.0
        return extremes(self.turning, x0, x1)

    def _rest(self) -> None:
        """Keep the bit stuck up to the end of the piece or its release; at a release, begin to slip."""
        over, below = self._excess_torque()
        ahead = first_positive(over)
        back = first_positive(below)
        x = ahead if ahead <= back else back
        if self.releases != 0 or x < SHORTEST_SLIP:
            self.direction = self.releases if self.releases != 0 else 1 if ahead <= back else -1
            self.releases = 0
            self._slip()
            if self.direction != 0:
                if not self.arrived:  # passing through rest is neither a stop nor a release
                    self.last_release = self.clock.time(self.cell, self.begin)
                    self.slips += 1
                return
            x = NONE
        if self.arrived:
            self.last_stop = self.clock.time(self.cell, self.begin)
        self.turning = ZERO
        self.releases = 0
        if x < 1.0:
            self._shorten(x, self.begin + x * (self.end - self.begin))
            self.releases = 1 if ahead <= back else -1

    def _excess_torque(self) -> tuple[Cubic, Cubic]:
        """Return by how much the torque on the stuck bit exceeds the static friction ahead and back [N m]."""
        z = self.law.twice_impedance
        a0, a1, a2, a3 = self.arriving
        static = self.law.static * self.weight
        rise = self.law.static * self.weight_rise
        ahead = (z * a0 - static, z * a1 - rise, z * a2, z * a3)
        back = (-(z * a0) - static, -(z * a1) - rise, -(z * a2), -(z * a3))
        return ahead, back

    def _slip(self) -> None:
        """Integrate the bit equation over the piece, or up to the place where the bit comes to rest."""
        begin = self._acceleration(0.0, self.speed)
        if self.speed == 0.0 and begin * self.direction < 0.0:
            begin = 0.0  # by rounding: at a release the friction is overcome
        speed, end = self._integrate(begin, 1.0)
        duration = (self.end - self.begin) * self.clock.cell
        self.turning = hermite(self.speed, speed, duration * begin, duration * end)
        t0, t1, t2, t3 = self.turning
        x = first_positive((-t0, -t1, -t2, -t3) if self.direction > 0 else self.turning)
        if x > 1.0:
            return
        if self.speed == 0.0 and x < SHORTEST_SLIP:
            self.direction = 0
            return
        x = self._stop(begin, x)
        end = self._acceleration(x, 0.0)
        self.turning = hermite(self.speed, 0.0, x * duration * begin, x * duration * end)
        self.arriving = restrict(self.arriving, 0.0, x)
        self.weight_rise = x * self.weight_rise
        self.end = self.begin + x * (self.end - self.begin)
        self.stops = True

    def _stop(self, begin: float, x: float) -> float:
        """Return where the integrator itself comes to rest, from the zero of its interpolant (Newton)."""
        duration = (self.end - self.begin) * self.clock.cell
        best = x
        for _ in range(ROOT_STEPS):
            speed, slope = self._integrate(begin, best)
            if slope == 0.0:
                return x
            best = best - speed / (slope * duration)
            if not 0.5 * x < best <= 1.0:  # a slip from rest has a second zero, its begin
                return x
        return best

    def _integrate(self, begin: float, x: float) -> tuple[float, float]:
        """Return speed and acceleration at x of the piece by one Runge-Kutta step of order four from its begin."""
        step = x * ((self.end - self.begin) * self.clock.cell)
        half = 0.5 * step
        middle = 0.5 * x
        k2 = self._acceleration(middle, self.speed + half * begin)
        k3 = self._acceleration(middle, self.speed + half * k2)
        k4 = self._acceleration(x, self.speed + step * k3)
        speed = self.speed + step * (0.16666666666666666 * (begin + 2.0 * (k2 + k3) + k4))
        return speed, self._acceleration(x, speed)

    def _acceleration(self, x: float, speed: float) -> float:
        """Return dv/dt at x of the piece [rad/s^2]."""
        law = self.law
        dry = law.dry(self.weight + x * self.weight_rise, self.direction, speed)
        return (law.twice_impedance * value(self.arriving, x) - law.damping * speed - dry) / law.inertia

    def _shorten(self, x: float, fraction: float) -> None:
        """End the piece at x, which is at `fraction` of the cell."""
        self.arriving = restrict(self.arriving, 0.0, x)
        self.turning = restrict(self.turning, 0.0, x)
        self.weight_rise = x * self.weight_rise
        self.end = fraction

    def state(self) -> dict[str, Any]:
        """Return everything that changes in time, as plain data."""
        return {name: getattr(self, name) for name in self.__slots__ if name not in _CONSTANT}

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state of :meth:`state` back."""
        for name, content in state.items():
            setattr(self, name, content)
        self.pressure = Ramp(*state["pressure"])


_CONSTANT = frozenset({"clock", "law"})
