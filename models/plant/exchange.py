"""The damping along the string, which changes two waves as they pass through each other.

With U the up-going and D the down-going wave, eq. (1) is, along the ways of the two waves,

    dU/dt = -(beta / 2 I) (U + D),    dD/dt = -(beta / 2 I) (U + D)

In the coordinates r = t + p xi, on which U would depend alone, and s = t - p xi, a block of one wave crosses a block of
the other in a square cell. Over a cell with r and s from 0 to 1 blocks

    dU/ds = -kappa (U + D),    dD/dr = -kappa (U + D),    kappa = beta h / (4 I)

with h the duration of a block. The trapezoidal rule for the wave itself, and for the other wave its mean, which changes
linearly across the cell, give a map that is exact for a string in uniform rotation. It needs no more of the other wave
than the mean: a jump or a kink passes through and leaves none behind.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..numerics.quartic import integral, square_integral
from .delay_line import DelayLine


@dataclass(frozen=True)
class Exchange:
    """Constants of a cell.

    Attributes
    ----------
    strength : float
        kappa.
    keep, share, decay : float
        What a wave keeps of itself and takes of the mean of the other, and what remains of the sum of the means.
    """

    strength: float
    keep: float
    share: float
    decay: float

    @classmethod
    def of(cls, strength: float) -> Exchange:
        """Derive the constants."""
        half = 0.5 * strength
        return cls(strength, (1.0 - half) / (1.0 + half), strength / (1.0 + half), (1.0 - strength) / (1.0 + strength))


def exchange(up: DelayLine, down: DelayLine, constants: Exchange) -> float:
    """Let all blocks of two full lines go on by one block, and return the energy lost per Z h [rad^2/s^2].

    First they cross those they meet at whole blocks of the way, then those they meet half a block farther on. The
    integrals of the squares are taken anew.
    """
    lost = _pass(up, down, back(down, newest(down)), constants, last=False)
    lost = lost + _pass(up, down, newest(down), constants, last=True)
    _sum_squares(up)
    _sum_squares(down)
    return lost


def newest(line: DelayLine) -> int:
    """Return where in the ring the newest block begins."""
    return back(line, (line.first + line.count) % len(line.pieces))


def back(line: DelayLine, index: int) -> int:
    """Return where the block before the one that begins at a place in the ring begins."""
    index = index - 1 if index > 0 else len(line.pieces) - 1
    while line.pieces[index][0] > 0.0:
        index = index - 1 if index > 0 else len(line.pieces) - 1
    return index


def forth(line: DelayLine, index: int) -> int:
    """Return where the block after the one that begins at a place in the ring begins."""
    while line.pieces[index][1] < 1.0:
        index = index + 1 if index + 1 < len(line.pieces) else 0
    return index + 1 if index + 1 < len(line.pieces) else 0


def _pass(up: DelayLine, down: DelayLine, below: int, constants: Exchange, *, last: bool) -> float:
    """Cross the blocks of `up`, from the oldest on, with those of `down`, from `below` back to the oldest."""
    lost = 0.0
    above = up.first
    while True:
        lost = lost + _cross(up, above, down, below, constants, last)
        if below == down.first:
            return lost
        above = forth(up, above)
        below = back(down, below)


def _cross(up: DelayLine, above: int, down: DelayLine, below: int, constants: Exchange, last: bool) -> float:
    """Cross two blocks and return the energy lost per Z h."""
    u, u_square = _moments(up, above)
    d, d_square = _moments(down, below)
    total = constants.decay * (u + d)
    u_after = 0.5 * (total + (u - d))
    d_after = 0.5 * (total - (u - d))
    _change(up, above, constants.keep, -constants.share * d, -constants.share * (d_after - d), last)
    _change(down, below, constants.keep, -constants.share * u, -constants.share * (u_after - u), last)
    # integral of (U + D)^2 over the cell, each wave being half way between before and after
    half = 0.5 * (1.0 + constants.keep)
    u_share = -0.25 * constants.share * (d + d_after)
    d_share = -0.25 * constants.share * (u + u_after)
    own = half * half * (u_square + d_square) + 2.0 * half * (u_share * u + d_share * d)
    own = own + (u_share * u_share + d_share * d_share)
    return 2.0 * constants.strength * (own + 0.5 * ((u + u_after) * (d + d_after)))


def _moments(line: DelayLine, index: int) -> tuple[float, float]:
    """Return the integrals of the wave and of its square over the block that begins at a place in the ring."""
    mean = square = 0.0
    while True:
        begin, end, wave, part = line.pieces[index]
        mean = mean + (end - begin) * integral(wave, 1.0)
        square = square + part
        if end >= 1.0:
            return mean, square
        index = index + 1 if index + 1 < len(line.pieces) else 0


def _change(line: DelayLine, index: int, keep: float, level: float, rise: float, last: bool) -> None:
    """Replace the wave of a block by `keep` times it and a straight line; before the last time, its square nearly."""
    while True:
        begin, end, (c0, c1, c2, c3, c4), square = line.pieces[index]
        length = end - begin
        start, slope = level + rise * begin, rise * length
        wave = (keep * c0 + start, keep * c1 + slope, keep * c2, keep * c3, keep * c4)
        if last:
            square = length * square_integral(wave)
        else:
            middle = start + 0.5 * slope
            mean = integral((c0, c1, c2, c3, c4), 1.0)
            square = keep * keep * square + length * (2.0 * keep * (middle * mean) + middle * middle)
        line.pieces[index] = (begin, end, wave, square)
        if end >= 1.0:
            return
        index = index + 1 if index + 1 < len(line.pieces) else 0


def _sum_squares(line: DelayLine) -> None:
    """Take the integral of the squared wave over the line anew."""
    total = 0.0
    index = line.first
    for _ in range(line.count):
        total = total + line.pieces[index][3]
        index = index + 1 if index + 1 < len(line.pieces) else 0
    line.square = total
    line.square_rest = 0.0
