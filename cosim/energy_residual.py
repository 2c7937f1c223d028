"""Energy that the coupling makes or loses: across a power bond, what is taken in is not just what is given.

Over each step the power taken in is the input as it was set, held or on a straight line, times the output of the same
component; the power given is the output that drives the input, times what its component was given in return. Between
communication points outputs are taken to go on straight lines. The difference, integrated over the step, is the energy
residual: positive where the coupling adds energy. An exact coupling has none. Energy residuals are due to Sadjina,
Kyllingstad, Skjong and Pedersen (2017), Energy conservation and power bonds in co-simulations, Engineering with
Computers 33, who take the powers at communication points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.power_bonds import Bond
from cosim.record import Trace
from cosim.signals import FloatArray
from cosim.system import split_name

Line = tuple[FloatArray, FloatArray]
"""Values at the beginnings and ends of steps."""


@dataclass(frozen=True)
class EnergyResidual:
    """What happened across a bond, J.

    Attributes
    ----------
    residual : ndarray, shape (rows,)
        Energy made in the step that led to each row, 0 in row 0.
    exchanged : float
        Energy taken in over all steps, each counted as positive.
    """

    residual: FloatArray
    exchanged: float

    def summary(self) -> dict[str, float]:
        """Return the sums, J: of the residuals, of their absolute values, and what was exchanged."""
        residual = self.residual
        return {"sum": float(residual.sum()), "absolute": float(np.abs(residual).sum()), "exchanged": self.exchanged}


def energy_residual(bond: Bond, trace: Trace) -> EnergyResidual:
    """Account for the energy that went over a bond.

    Parameters
    ----------
    bond : Bond
        Of the system that was run.
    trace : Trace
        The whole recording, or a part of successive rows.
    """
    sizes = np.diff(trace.times)
    effort = _output(bond.output, trace)
    taken = bond.factor * _integral(_input(bond.input, trace, sizes), effort, sizes)
    returned = effort if bond.back is None else _input(bond.back, trace, sizes)
    given = bond.factor * _integral(_output(bond.source, trace), returned, sizes)
    return EnergyResidual(np.concatenate([[0.0], taken - given]), float(np.abs(taken).sum()))


def _integral(first: Line, second: Line, sizes: FloatArray) -> FloatArray:
    """Integrate the product of two straight lines over each step."""
    (a, b), (c, d) = first, second
    return sizes / 6.0 * (2.0 * a * c + a * d + b * c + 2.0 * b * d)


def _output(name: str, trace: Trace) -> Line:
    """Return an output at both ends of each step."""
    component, variable = split_name(name)
    section = trace.blocks[component].outputs["Real"]
    values = section.values[:, section.column(variable)].astype(np.float64)
    return values[:-1], values[1:]


def _input(name: str, trace: Trace, sizes: FloatArray) -> Line:
    """Return an input at both ends of each step: it ends where it is recorded, and came there with its slope."""
    component, variable = split_name(name)
    section, slopes = trace.blocks[component].inputs["Real"], trace.blocks[component].slopes
    index = section.column(variable)
    ends = section.values[1:, index].astype(np.float64)
    column = None if slopes is None else slopes.column(int(section.references[index]))
    return (ends if slopes is None or column is None else ends - sizes * slopes.values[1:, column]), ends
