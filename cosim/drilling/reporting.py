"""Report a run that turns a bit: measures, energy balance, and a figure laid out like the paper's.

This is all that running and streaming know of drilling: which columns it takes, what is found in them, how that is
written to a manifest and shown in a table, and what is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict, TypeVar, Unpack

import numpy as np

from cosim.drilling import energy, oscillation
from cosim.drilling.energy import energy_balance, folding_sentence
from cosim.drilling.oscillation import Measures, measure
from cosim.drilling.severity import rotation_of, severity_of
from cosim.recording import figure
from cosim.recording.figure import MOST_PANELS, View
from cosim.recording.result import Column, Result

__all__ = [
    "NAMES", "Findings", "Looks", "default_signals", "draw", "find", "headings", "rotation_of", "severity_of",
    "view_of", "watched",
]  # fmt: skip

Found = TypeVar("Found")

NAMES = {
    "bit_speed": "Bit speed",
    "bit_torque": "Torque on bit",
    "top_speed": "Top speed",
    "top_torque": "Top torque",
    "WOB": "Weight on bit",
    "Omega": "Drive speed",
}
"""Words for variables, by their names."""


STEADY = 0.5
"""Greatest less least bit speed of what is called steady [rad/s]."""

_ENERGIES = {
    "stored_at_start": "stored at the start",
    "drive_work": "given by the drive",
    "top_loss": "lost at the top",
    "string_loss": "lost along the string",
    "bit_loss": "lost at the bit",
    "folded": "taken from the waves by the method",
    "stored": "stored at the end",
    "residual": "not accounted for",
}


class Looks(TypedDict, total=False):
    """Looks of a view that are no matter of drilling."""

    begin: float
    end: float
    overlay: bool
    units: str


@dataclass(frozen=True)
class Findings:
    """Measures and energy balance of a run; None where no component tells what they take.

    Attributes
    ----------
    measures : Measures or None
        Of the first component that has a bit.
    energy : mapping of str to float, or None
        Balance of the first component that tells it: the time it is counted from [s], and energies [J], as
        `cosim.drilling.energy.EnergyBalance.summary` has them.
    """

    measures: Measures | None
    energy: Mapping[str, float] | None

    def to_json(self) -> dict[str, Any]:
        """Return the entries of a manifest."""
        return {"measures": self.measures.to_json() if self.measures else None, "energy": self.energy}

    @classmethod
    def from_json(cls, entry: Mapping[str, Any]) -> Findings:
        """Read the entries of a manifest."""
        measures = entry["measures"]
        return cls(None if measures is None else Measures.from_json(measures), entry["energy"])

    def cells(self) -> tuple[str, ...]:
        """Return the row of a table whose columns `headings` names; dashes where there is nothing."""
        return oscillation.cells(self.measures)

    def verdict(self) -> tuple[str, str]:
        """Judge the motion of the bit at the end of the run, in a word or two and in a sentence."""
        found = self.measures
        if found is None:
            return "not judged", "nothing tells how a bit moved"
        stuck, swing = float(found.stuck_fraction), float(found.peak - found.minimum)
        if stuck >= 1.0:
            return "stuck", f"the bit does not turn over {found.window}"
        if stuck > 0.0:
            repeats = f", every {found.period:.6g} s" if found.period is not None else ""
            return "stick-slip", f"the bit is stuck {100.0 * stuck:.3g} % of the time{repeats}, over {found.window}"
        if swing > STEADY:
            return (
                "oscillating",
                f"the bit does not stick, but its speed swings by {swing:.3g} rad/s over {found.window}",
            )
        return "steady", f"the speed of the bit swings by {swing:.3g} rad/s over {found.window}"

    def balance(self) -> dict[str, float]:
        """Return the energies of the balance [J] by what they are; nothing where no balance is known."""
        if self.energy is None:
            return {}
        return {text: self.energy[name] for name, text in _ENERGIES.items() if name in self.energy}

    def sentence(self) -> str:
        """Say over which window was measured, and what folded breaks did, if there were any."""
        measured = f"measured over {self.measures.window}" if self.measures else "nothing to measure"
        folding = None if self.energy is None else folding_sentence(self.energy)
        return measured if folding is None else f"{measured}; {folding}"


def find(result: Result) -> Findings:
    """Measure the first component that has a bit, and balance the energy of the first that tells it."""
    balance = _of_first(result, energy_balance)
    summary = None if balance is None else {"since": float(result.time[0]), **balance.summary()}
    return Findings(_of_first(result, measure), summary)


def headings() -> tuple[str, ...]:
    """Return what the columns of a table of findings are."""
    return oscillation.headings()


def watched(columns: Sequence[Column], signals: Sequence[str]) -> list[Column]:
    """Choose the columns that findings and the figure take; `signals` are those the figure is asked to show."""
    shown = signals or default_signals({column.name: column.dtype for column in columns})
    needed = {*oscillation.needed(), *energy.NEEDED, *energy.LOSSES, energy.FOLDED, energy.FOLDS}
    return [column for column in columns if column.name in shown or column.name.partition(".")[2] in needed]


def _of_first(result: Result, look: Callable[[Result, str], Found | None]) -> Found | None:
    """Return what is found of the first component that has it."""
    components = dict.fromkeys(name.partition(".")[0] for name in result.names)
    found = (look(result, component) for component in components)
    return next((one for one in found if one is not None), None)


def draw(path: Path, title: str, results: Mapping[str, Result], signals: Sequence[str] = ()) -> None:
    """Draw trajectories over time into a file, which replaces one that is there when it is complete.

    Parameters
    ----------
    path : Path
        The file.
    title : str
        Above everything.
    results : mapping of str to Result
        One column of panels each, with the name above it.
    signals : sequence of str, optional
        What to show, one row of panels each, as ``component.variable``; by default bit speed and torque on bit where
        there are such, else the first outputs.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    figure.draw(path, title, results, view_of(next(iter(results.values())), signals))


def view_of(result: Result, signals: Sequence[str] = (), **how: Unpack[Looks]) -> View:
    """Return how to show a result: variables by what they are called in drilling, and by default those of the bit."""
    shown = list(signals) or default_signals({name: result[name].dtype for name in result.names})
    return View(shown, names=NAMES, **how)


def default_signals(types: Mapping[str, np.dtype[Any]]) -> list[str]:
    """Choose by names and types what to show: bit speed and torque on bit, or else the first numbers recorded."""
    for name in types:
        component, _, variable = name.partition(".")
        if variable == "bit_speed" and f"{component}.bit_torque" in types:
            return [name, f"{component}.bit_torque"]
    return [name for name, dtype in types.items() if dtype == np.float64][:MOST_PANELS]
