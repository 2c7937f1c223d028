"""The bit of a string with damping along it: the condition of `models.plant.bit` with the half cell next to it."""

from __future__ import annotations

from ..numerics.quartic import subtract
from .bit import Bit
from .damped_end import DampedEnd
from .delay_line import DelayLine


class DampedBit(DampedEnd):
    """The half cell at the bit."""

    __slots__ = ()

    def open(self, bit: Bit, down: DelayLine) -> None:
        """Let the bit take up the next piece."""
        if bit.begin >= bit.incoming[1]:
            self.take(down)
        own = (bit.speed, self._coming_rise(bit, self.raw[1]))
        bit.incoming = self.incident(bit.begin, -1.0, own)
        bit.open(down)

    def close(self, bit: Bit, up: DelayLine) -> None:
        """Send the piece of the bit up the string and go to its end."""
        sent = subtract(bit.turning, bit.incident)
        wave = self.outgoing(bit.begin, bit.end, bit.incident, sent, bit.turning)
        up.push(bit.begin, bit.end, wave)
        bit.finish()

    def settled_by(self, bit: Bit, x: float) -> float:
        """Return what the pieces up to x of the present one have settled [rad^2/s^2 blocks]."""
        return self.settled_at(bit.begin, bit.end, bit.incident, bit.turning, x)

    def square_by(self, bit: Bit, x: float) -> float:
        """Return the integral of the squared bit speed up to x of the present piece [rad^2/s^2 blocks]."""
        return self.square_at(bit.begin, bit.end, bit.turning, x)

    def _coming_rise(self, bit: Bit, end: float) -> float:
        """Return about how much the bit speed rises up to the end of the piece, as far as its begin tells [rad/s]."""
        law = bit.law
        duration = (end - bit.begin) * bit.clock.block
        weight, _ = bit.wob.over(bit.clock, bit.block, bit.begin, end)
        torque = law.twice_impedance * self.wave_at(bit.begin)
        if bit.speed == 0.0:
            holding = law.friction.static * weight
            if abs(torque) <= holding:
                return 0.0
            return duration * (torque - holding if torque > 0.0 else torque + holding) / law.inertia
        direction = 1 if bit.speed > 0.0 else -1
        _, friction, _ = law.friction.at(weight, direction * bit.speed)
        dry = friction * direction
        return duration * (torque - law.damping * bit.speed - dry) / law.inertia
