"""Balance the energy of a run: what the drive gave is stored, or lost in the sliding top and at the bit.

It is eq. (8) of Saldivar et al. (2011), I L / 2 times, with the drive's side of the sliding top as well; eq. (11) in
docs/model.md. Every term is an integral that the plant accumulates on its own, so that the balance is a check of the
computation and not a definition.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cosim.recording.result import Result
from cosim.system.signals import FloatArray

LOSSES = ("top_loss", "bit_loss", "string_loss")
"""Outputs that tell where energy is lost; a plant has those that apply to it."""
FOLDED = "folded_energy"
"""Energy a plant took from its waves to simplify them: an error of the method, and counted as such."""
FOLDS = "breaks_folded"
"""How often it did that where it was not negligible."""
NEEDED = ("energy", "work_in", "drive_work", "top_loss", "bit_loss")
"""Outputs of a plant from which its energy is balanced."""


@dataclass(frozen=True)
class EnergyBalance:
    """Balance of the energy of string and drive, at all communication points.

    Attributes
    ----------
    component : str
        Whose string it is.
    stored : ndarray, shape (n,)
        Energy in string and bit, J.
    drive_work : ndarray, shape (n,)
        Given by the drive since the start, J.
    losses : dict of str to ndarray, each of shape (n,)
        Lost since the start, J, by output.
    folded : ndarray, shape (n,)
        Taken from the waves by the method since the start, J; 0 where a plant does no such thing.
    residual : ndarray, shape (n,)
        Stored since the start and not accounted for by drive, losses and method, J.
    put_in : ndarray, shape (n,)
        The energy at the start and the most that had been put into the string until then or drawn from it, J.
    folds : int
        Breaks folded although they were not negligible.
    wave_change : float or None
        What folding did to the waves: the root mean square of their change, rad/s. A fold is a least-squares fit, so
        that the energy it takes is that of the change. None where the string's impedance is not known.
    """

    component: str
    stored: FloatArray
    drive_work: FloatArray
    losses: dict[str, FloatArray]
    folded: FloatArray
    residual: FloatArray
    put_in: FloatArray
    folds: int = 0
    wave_change: float | None = None

    @property
    def worst(self) -> float:
        """Return the greatest residual as a part of what had been put in until then; 0 if nothing ever was."""
        part = np.divide(np.abs(self.residual), self.put_in, out=np.zeros_like(self.put_in), where=self.put_in > 0.0)
        return float(part.max())

    def summary(self) -> dict[str, float]:
        """Return what there is at the end, J, and the greatest residual as a part of what was put in."""
        final = {name: float(values[-1]) for name, values in self.losses.items()}
        folded = {"breaks_folded": float(self.folds)} if self.folds else {}
        if self.folds and self.wave_change is not None:
            folded["wave_change"] = self.wave_change
        return {
            "stored_at_start": float(self.stored[0]),
            "stored": float(self.stored[-1]),
            "drive_work": float(self.drive_work[-1]),
            **final,
            "folded": float(self.folded[-1]),
            "residual": float(self.residual[-1]),
            "worst_residual": self.worst,
            **folded,
        }


def energy_balance(result: Result, component: str = "plant") -> EnergyBalance | None:
    """Balance the energy of a run.

    Parameters
    ----------
    result : Result
        A run.
    component : str
        Name of the plant.

    Returns
    -------
    EnergyBalance or None
        None if the component lacks the outputs this is taken from.
    """
    if any(f"{component}.{name}" not in result for name in NEEDED):
        return None

    def since_start(name: str) -> FloatArray:
        """Return an output less its first value."""
        values = np.asarray(result[f"{component}.{name}"], dtype=np.float64)
        return values - values[0]

    losses = {name: since_start(name) for name in LOSSES if f"{component}.{name}" in result}
    stored = np.asarray(result[f"{component}.energy"], dtype=np.float64)
    folded = since_start(FOLDED) if f"{component}.{FOLDED}" in result else np.zeros_like(stored)
    driven = since_start("drive_work")
    kept = driven - folded
    for lost in losses.values():
        kept = kept - lost
    return EnergyBalance(
        component=component,
        stored=stored,
        drive_work=driven,
        losses=losses,
        folded=folded,
        residual=stored - stored[0] - kept,
        put_in=stored[0] + np.maximum.accumulate(np.abs(since_start("work_in"))),
        folds=int(since_start(FOLDS)[-1]) if f"{component}.{FOLDS}" in result else 0,
        wave_change=_wave_change(result, component, float(folded[-1])),
    )


def _wave_change(result: Result, component: str, folded: float) -> float | None:
    """Return the root mean square of what folding changed about the waves [rad/s], from the energy it took [J].

    The energy of a wave w that passes in a time is the impedance times the integral of its square (model.md, (10)).
    """
    known = result.record.get("components", {}).get(component, {}).get("parameters", {})
    factors = [known.get(name) for name in ("I", "G", "J")]
    duration = float(result.time[-1] - result.time[0])
    if not all(isinstance(each, float) and each > 0.0 for each in factors) or duration <= 0.0:
        return None
    impedance = math.sqrt(math.prod(factors))
    return math.sqrt(max(0.0, folded) / (impedance * duration))


def folding_sentence(energy: Mapping[str, float]) -> str | None:
    """Say what folded breaks did to a run, from `EnergyBalance.summary`; None if none were folded."""
    if not energy.get("breaks_folded"):
        return None
    sentence = (
        f"{energy['breaks_folded']:.0f} breaks folded, which took {energy['folded']:.2g} J of the "
        f"{energy['drive_work']:.2g} J that the drive gave"
    )
    change = energy.get("wave_change")
    return sentence if change is None else f"{sentence} and changed waves by {change:.1g} rad/s in the root mean square"
