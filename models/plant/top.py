"""The top end: the up-going wave is incident, the drive turns, the down-going wave is outgoing.

D(t)    = -Upsilon U_b(t - Gamma) + (c_a / Lambda) Omega(t)
ydot(t) = U_b(t - Gamma) + D(t)
"""

from __future__ import annotations

from typing import Any

from ..numerics.quartic import ZERO, Quartic, add, integral, product_integral, restrict, value
from .clock import SNAP, Clock, Ramp
from .delay_line import NOTHING, DelayLine
from .parameters import DrillstringParameters


class Top:
    """The top boundary condition, always one piece ahead: the piece that holds the present.

    Attributes
    ----------
    block, begin, end : int, float, float
        The piece: its block and its fractions of the block.
    incident, outgoing : Quartic
        U_b(t - Gamma) and D(t) on the piece [rad/s].
    incoming : Piece
        The piece of the up-going wave that `incident` is a part of.
    omega : Ramp
        The drive [rad/s].
    angle : float
        Angle of the top [rad] up to `begin`.
    work, driven, slid : float
        Work on the string, work of the drive, and what is lost between them in the sliding [J] up to `begin`.
    """

    __slots__ = (
        "angle", "begin", "block", "clock", "driven", "end", "incident", "incoming", "omega", "outgoing", "reflection",
        "slid", "sliding", "transmission", "work",
    )  # fmt: skip

    def __init__(self, parameters: DrillstringParameters, clock: Clock, angle: float, omega: Ramp) -> None:
        self.reflection = parameters.reflection
        self.transmission = parameters.transmission
        self.sliding = parameters.c_a
        self.clock = clock
        self.block = 0
        self.begin = 0.0
        self.end = 0.0
        self.incident = self.outgoing = ZERO
        self.incoming = NOTHING
        self.angle = angle
        self.work = self.driven = self.slid = 0.0
        self.omega = omega

    def open(self, up: DelayLine) -> None:
        """Take up the next piece: from `begin` to the end of the incident piece."""
        if self.begin >= self.incoming[1]:
            self.incoming = up.pop()
            self.begin = self.incoming[0]
        self.end = self.incoming[1]
        first, last, wave, _ = self.incoming
        self.incident = restrict(wave, (self.begin - first) / (last - first), 1.0)
        omega, rise = self.omega.over(self.clock, self.block, self.begin, self.end)
        self.outgoing = (
            self.transmission * omega - self.reflection * self.incident[0],
            self.transmission * rise - self.reflection * self.incident[1],
            -self.reflection * self.incident[2],
            -self.reflection * self.incident[3],
            -self.reflection * self.incident[4],
        )

    def close(self, down: DelayLine) -> None:
        """Send the piece down the string and go to its end."""
        down.push(self.begin, self.end, self.outgoing)
        self.finish()

    def finish(self) -> None:
        """Go to the end of the piece."""
        duration = (self.end - self.begin) * self.clock.block
        self.angle += duration * integral(self.speed(), 1.0)
        work, driven, slid = self.power_integrals(1.0)
        self.work += duration * work
        self.driven += duration * driven
        self.slid += duration * slid
        self.begin = self.end
        if self.end >= 1.0:
            self.block += 1
            self.begin = 0.0
            self.incoming = NOTHING

    def cut(self, fraction: float) -> bool:
        """End the piece at a fraction of the block, because Omega changes there; False if it begins there anyway.

        The piece is then to be closed, and in any case a new one to be opened.
        """
        if not fraction - self.begin > SNAP:
            return False
        if self.end - fraction > SNAP:
            x = (fraction - self.begin) / (self.end - self.begin)
            self.incident = restrict(self.incident, 0.0, x)
            self.outgoing = restrict(self.outgoing, 0.0, x)
            self.end = fraction
        return True

    def speed(self) -> Quartic:
        """Return ydot on the piece [rad/s]."""
        return add(self.incident, self.outgoing)

    def drive(self, x: float) -> float:
        """Return Omega at x of the piece [rad/s]."""
        omega, rise = self.omega.over(self.clock, self.block, self.begin, self.end)
        return omega + x * rise

    def torque(self, x: float) -> float:
        """Return the torque of the drive on the string, c_a (Omega - ydot), at x of the piece [N m]."""
        return self.sliding * (self.drive(x) - value(self.speed(), x))

    def power_integrals(self, x: float) -> tuple[float, float, float]:
        """Return the integrals of top_torque times top_speed, Omega and their difference, 0 to x of the piece [W]."""
        speed = self.speed()
        omega, rise = self.omega.over(self.clock, self.block, self.begin, self.end)
        drive = (omega, rise, 0.0, 0.0, 0.0)
        slip = (omega - speed[0], rise - speed[1], -speed[2], -speed[3], -speed[4])
        work = self.sliding * product_integral(slip, speed, x)
        driven = self.sliding * product_integral(slip, drive, x)
        return work, driven, self.sliding * product_integral(slip, slip, x)

    def state(self) -> dict[str, Any]:
        """Return everything that changes in time, as plain data."""
        return {name: getattr(self, name) for name in self.__slots__ if name not in _CONSTANT}

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state of :meth:`state` back."""
        for name, content in state.items():
            setattr(self, name, content)
        self.omega = Ramp(*state["omega"])


_CONSTANT = frozenset({"clock", "reflection", "sliding", "transmission"})
