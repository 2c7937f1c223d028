"""The top of a string with damping along it: the condition of `models.plant.top` with the half cell next to it."""

from __future__ import annotations

from .damped_end import DampedEnd
from .delay_line import DelayLine
from .top import Top


class DampedTop(DampedEnd):
    """The half cell at the top."""

    __slots__ = ()

    def open(self, top: Top, up: DelayLine) -> None:
        """Let the top take up the next piece."""
        if top.begin >= top.incoming[1]:
            self.take(up)
        omega, rise = top.omega.over(top.clock, top.block, top.begin, self.raw[1])
        own = (top.transmission * omega, top.transmission * rise)
        top.incoming = self.incident(top.begin, -top.reflection, own)
        top.open(up)

    def close(self, top: Top, down: DelayLine) -> None:
        """Send the piece of the top down the string and go to its end."""
        wave = self.outgoing(top.begin, top.end, top.incident, top.outgoing, top.speed())
        down.push(top.begin, top.end, wave)
        top.finish()

    def settled_by(self, top: Top, x: float) -> float:
        """Return what the pieces up to x of the present one have settled [rad^2/s^2 blocks]."""
        return self.settled_at(top.begin, top.end, top.incident, top.speed(), x)

    def square_by(self, top: Top, x: float) -> float:
        """Return the integral of the squared top speed up to x of the present piece [rad^2/s^2 blocks]."""
        return self.square_at(top.begin, top.end, top.speed(), x)
