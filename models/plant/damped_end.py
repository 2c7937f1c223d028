"""The damping next to an end of the string, where the outgoing wave crosses the incident one it was made of.

There a cell of `models.plant.exchange` is cut in half by the end. The wave Y that is incident at x of a block was q
before it met what the end has sent, S, since the begin of the block, and S becomes the outgoing wave d when it has met
what is still to come:

    Y(x) = q(x) - kappa (x (q + Y) / 2 + integral of S from 0 to x - kappa w x^2 / 2)
    d(x) = S(x) - kappa ((1 - x) (S + d) / 2 + integral of q from x to 1 - kappa w x (1 - x))

with w the speed of the end. Both are solved by repeated substitution; in uniform rotation they are exact.
"""

from __future__ import annotations

from typing import Any

from ..numerics.quartic import THIRD, Quartic, integral, product_integral, restrict, square_integral, subtract
from .bit import Bit
from .delay_line import NOTHING, DelayLine, Piece
from .top import Top

SUBSTITUTIONS = 8


class DampedEnd:
    """The half cell at one end.

    Attributes
    ----------
    raw : Piece
        The incident piece, as it was before it met what the end sends.
    following : float
        Integral of the wave over the rest of the block after `raw` [rad/s blocks].
    sent : float
        Integral of what the end has sent since the begin of the block [rad/s blocks].
    square : float
        Integral of the squared speed of the end, in blocks [rad^2/s^2].
    settled : float
        What the pieces of this block change in the integral of the squared waves, so that it follows from what has
        come in, been sent and been lost so far; zero, nearly, at the end of the block [rad^2/s^2].
    """

    __slots__ = ("following", "raw", "sent", "settled", "square", "strength")

    def __init__(self, strength: float) -> None:
        self.strength = strength
        self.raw = NOTHING
        self.following = self.sent = self.square = self.settled = 0.0

    def take(self, line: DelayLine) -> None:
        """Take the next piece out of the line."""
        self.raw = line.pop()
        self.following = 0.0
        index, end = line.first, self.raw[1]
        while end < 1.0:
            begin, end, wave, _ = line.pieces[index]
            self.following = self.following + (end - begin) * integral(wave, 1.0)
            index = index + 1 if index + 1 < len(line.pieces) else 0

    def incident(self, begin: float, echo: float, own: tuple[float, float]) -> Piece:
        """Return the incident piece from `begin` on, while the end sends `echo` times it and a straight line.

        Parameters
        ----------
        begin : float
            Fraction of the block.
        echo : float
            Share of the incident wave that the end sends back.
        own : (float, float)
            What it sends of its own at `begin`, and its rise to the end of the piece [rad/s].
        """
        end = self.raw[1]
        length = end - begin
        q = self._wave(begin, end)
        kappa = self.strength
        y0, y1, y2, y3, y4 = q
        for _ in range(SUBSTITUTIONS):
            m0, m1, m2, m3, m4 = (
                0.5 * (q[0] + y0), 0.5 * (q[1] + y1), 0.5 * (q[2] + y2), 0.5 * (q[3] + y3), 0.5 * (q[4] + y4)
            )  # fmt: skip
            bend = 0.5 * kappa * ((1.0 + echo) * y0 + own[0])
            s0, s1, s2, s3 = own[0] + echo * y0, own[1] + echo * y1, echo * y2, echo * y3
            y0 = q[0] - kappa * (begin * m0 + self.sent - bend * (begin * begin))
            y1 = q[1] - kappa * (begin * m1 + length * (m0 + s0) - 2.0 * bend * (begin * length))
            y2 = q[2] - kappa * (begin * m2 + length * (m1 + 0.5 * s1) - bend * (length * length))
            y3 = q[3] - kappa * (begin * m3 + length * (m2 + THIRD * s2))
            y4 = q[4] - kappa * (begin * m4 + length * (m3 + 0.25 * s3))
        return (begin, end, (y0, y1, y2, y3, y4), 0.0)

    def outgoing(self, begin: float, end: float, incident: Quartic, sent: Quartic, speed: Quartic) -> Quartic:
        """Return the outgoing wave that the sent one becomes on a piece, and count the piece.

        Parameters
        ----------
        begin, end : float
            Fractions of the block.
        incident, sent, speed : Quartic
            The incident and the sent wave, and the speed of the end, on the piece [rad/s].
        """
        length = end - begin
        kappa = self.strength
        last = self.raw[1]
        rest = self.following + (last - begin) * integral(self._wave(begin, last), 1.0)
        q = self._wave(begin, end)
        after = 1.0 - begin
        bend = kappa * speed[0]
        d0, d1, d2, d3, d4 = sent
        for _ in range(SUBSTITUTIONS):
            m0, m1, m2, m3, m4 = (
                0.5 * (sent[0] + d0), 0.5 * (sent[1] + d1), 0.5 * (sent[2] + d2), 0.5 * (sent[3] + d3),
                0.5 * (sent[4] + d4),
            )  # fmt: skip
            d0 = sent[0] - kappa * (after * m0 + rest - bend * (begin * after))
            d1 = sent[1] - kappa * (after * m1 - length * (m0 + q[0]) - bend * (length * (after - begin)))
            d2 = sent[2] - kappa * (after * m2 - length * (m1 + 0.5 * q[1]) + bend * (length * length))
            d3 = sent[3] - kappa * (after * m3 - length * (m2 + THIRD * q[2]))
            d4 = sent[4] - kappa * (after * m4 - length * (m3 + 0.25 * q[3]))
        outgoing = (d0, d1, d2, d3, d4)
        turned = square_integral(speed)
        change = (square_integral(q) - square_integral(incident)) + (square_integral(sent) - square_integral(outgoing))
        self.square = self.square + length * turned
        self.settled = self.settled + length * (change - kappa * turned) if end < 1.0 else 0.0
        self.sent = self.sent + length * integral(sent, 1.0) if end < 1.0 else 0.0
        return outgoing

    def wave_at(self, begin: float) -> float:
        """Return the wave at a place of the piece, as it was before it met what the end sends [rad/s]."""
        return self._wave(begin, self.raw[1])[0]

    def square_at(self, begin: float, end: float, speed: Quartic, x: float) -> float:
        """Return `square` at x of a piece that is not counted yet."""
        return self.square + (end - begin) * product_integral(speed, speed, x)

    def settled_at(self, begin: float, end: float, incident: Quartic, speed: Quartic, x: float) -> float:
        """Return `settled` at x of a piece that is not counted yet."""
        q = self._wave(begin, end)
        change = product_integral(q, q, x) - product_integral(incident, incident, x)
        return self.settled + (end - begin) * (change - self.strength * product_integral(speed, speed, x))

    def _wave(self, begin: float, end: float) -> Quartic:
        """Return a part of the piece as it was before it met what the end sends."""
        first, last, wave, _ = self.raw
        return restrict(wave, (begin - first) / (last - first), (end - first) / (last - first))

    def state(self) -> dict[str, Any]:
        """Return everything that changes in time, as plain data."""
        return {name: getattr(self, name) for name in DampedEnd.__slots__ if name != "strength"}

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state of :meth:`state` back."""
        for name, content in state.items():
            setattr(self, name, content)


class DampedTop(DampedEnd):
    """The half cell at the top, before the condition of `models.plant.top`."""

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


class DampedBit(DampedEnd):
    """The half cell at the bit, before the condition of `models.plant.bit`."""

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
