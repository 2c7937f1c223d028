"""How far two half steps and a whole one lie apart, and what that says of the error."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from cosim.master.stepping.channel import Channel
from cosim.master.stepping.stage import END, MIDDLE, WHOLE, Part


@dataclass(frozen=True)
class _Watched:
    """A connection; `waveform` says whether what the input was assumed to be within the step matters."""

    channel: Channel
    waveform: bool
    order: int


class ErrorEstimate:
    """Estimates the error of two half steps from the difference to a whole one.

    Where an input goes on a straight line, the assumption within a step is of second order; where it is held, of first.
    What an FMU makes of a held input need not show at the end of the step, if it delays or integrates. Only where each
    of its outputs depends directly on inputs it is taken to show there.

    Parameters
    ----------
    parts : iterable of Part
        The components whose steps are repeated.
    tolerance : float
        Of the error, relative to the greater of value and nominal value.
    leads : bool
        Whether the algorithm gives inputs the values at the end of the step, on a straight line where it can.
    """

    def __init__(self, parts: Iterable[Part], tolerance: float, *, leads: bool) -> None:
        self.tolerance = tolerance
        self._watched = [
            _Watched(channel, straight or not leads or _hides(part), 2 if straight else 1)
            for part in parts
            for channel in part.channels
            if channel.continuous
            for straight in [leads and channel.target.slopes is not None]
        ]

    @property
    def order(self) -> int:
        """With which power of the step size the estimate goes to zero."""
        return min((watched.order for watched in self._watched if watched.waveform), default=2)

    def estimate(self, size: float) -> float:
        """Return the greatest estimate for a step of a size [s], relative to the tolerance."""
        worst = 0.0
        for watched in self._watched:
            error = _difference(watched, size) / (2**watched.order - 1)
            allowed = self.tolerance * max(watched.channel.nominal, abs(watched.channel.output(END)))
            worst = max(worst, error / allowed) if math.isfinite(error) else math.inf
        return worst


def _difference(watched: _Watched, size: float) -> float:
    """Return by how much the whole step differs from the halves, in the unit of the variable."""
    channel, target = watched.channel, watched.channel.target
    outputs = abs(channel.output(WHOLE) - channel.output(END))
    if not watched.waveform:
        return outputs
    end, middle = target.value(WHOLE), target.value(WHOLE) - 0.5 * size * target.slope(WHOLE)
    second_half = target.value(END) - 0.5 * size * target.slope(END)
    return max(outputs, abs(end - target.value(END)), abs(middle - target.value(MIDDLE)), abs(middle - second_half))


def _hides(part: Part) -> bool:
    """Whether a component has an output that no input feeds through to."""
    description = part.slave.description
    return any(not description.fed_through(variable.name) for variable in description.with_causality("output"))
