"""Energy that the coupling makes or loses: across a power bond, what is taken in is not just what is given.

Over each step the power taken in is the input as it was set, held or on a straight line, times the output of the same
component; the power given is the output that drives the input, times what its component was given in return. Between
communication points outputs are taken to go on straight lines. The difference, integrated over the step, is the energy
residual: positive where the coupling adds energy. An exact coupling has none. Energy residuals are due to Sadjina,
Kyllingstad, Skjong and Pedersen (2017), Energy conservation and power bonds in co-simulations, Engineering with
Computers 33, who take the powers at communication points.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cosim.recording.record import Window
from cosim.system.power_bonds import Bond
from cosim.system.signals import FloatArray
from cosim.system.structure import split_name

Line = tuple[FloatArray, FloatArray]
"""Values at the beginnings and ends of steps."""


@dataclass
class EnergyAccount:
    """What has happened across a bond so far.

    Attributes
    ----------
    bond : Bond
        Of the system that is run.
    sum, absolute : float
        Of the residuals, and of their absolute values, J.
    exchanged : float
        Energy taken in over all steps, each counted as positive, J.
    """

    bond: Bond
    sum: float = 0.0
    absolute: float = 0.0
    exchanged: float = 0.0

    def take(self, window: Window) -> FloatArray:
        """Account for a window; return the energy made in the step that led to each row, 0 for the first [J]."""
        sizes = np.diff(window.times)
        effort = _output(self.bond.output, window)
        taken = self.bond.factor * _integral(_input(self.bond.input, window, sizes), effort, sizes)
        returned = effort if self.bond.back is None else _input(self.bond.back, window, sizes)
        given = self.bond.factor * _integral(_output(self.bond.source, window), returned, sizes)
        residual = taken - given
        self.sum += float(residual.sum())
        self.absolute += float(np.abs(residual).sum())
        self.exchanged += float(np.abs(taken).sum())
        return np.concatenate([[0.0], residual])

    def summary(self) -> dict[str, float]:
        """Return the sums [J]."""
        return {"sum": self.sum, "absolute": self.absolute, "exchanged": self.exchanged}

    def restore(self, summary: Mapping[str, float]) -> None:
        """Go on from sums."""
        self.sum, self.absolute, self.exchanged = (summary[name] for name in ("sum", "absolute", "exchanged"))


def _integral(first: Line, second: Line, sizes: FloatArray) -> FloatArray:
    """Integrate the product of two straight lines over each step."""
    (a, b), (c, d) = first, second
    return sizes / 6.0 * (2.0 * a * c + a * d + b * c + 2.0 * b * d)


def _output(name: str, window: Window) -> Line:
    """Return an output at both ends of each step."""
    component, variable = split_name(name)
    section = window.blocks[component].outputs["Real"]
    values = section.values[:, section.column(variable)].astype(np.float64)
    return values[:-1], values[1:]


def _input(name: str, window: Window, sizes: FloatArray) -> Line:
    """Return an input at both ends of each step: it ends where it is recorded, and came there with its slope."""
    component, variable = split_name(name)
    section, slopes = window.blocks[component].inputs["Real"], window.blocks[component].slopes
    index = section.column(variable)
    ends = section.values[1:, index].astype(np.float64)
    column = None if slopes is None else slopes.column(int(section.references[index]))
    return (ends if slopes is None or column is None else ends - sizes * slopes.values[1:, column]), ends
