"""Report a run that turns a bit: measures, energy balance, and a figure laid out like the paper's.

This is all that running and streaming know of drilling: which columns it takes, what is found in them, how that is
written to a manifest and shown in a table, and what is drawn.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from cosim.drilling import energy, oscillation
from cosim.drilling.energy import energy_balance, folding_sentence
from cosim.drilling.oscillation import Measures, measure
from cosim.drilling.severity import rotation_of, severity_of
from cosim.errors import printable
from cosim.files import replace_file
from cosim.recording.result import Column, Result

__all__ = [
    "Findings", "blank_figure", "default_signals", "draw", "find", "headings", "rotation_of", "save_figure",
    "severity_of", "watched",
]  # fmt: skip

Found = TypeVar("Found")

# Colours that stay apart for colour-blind readers and in grey.
_COLOURS = ("#0b5394", "#b45309", "#2f6f4f", "#7a3b69")
_NAMES = {
    "bit_speed": "Bit speed",
    "bit_torque": "Torque on bit",
    "top_speed": "Top speed",
    "top_torque": "Top torque",
    "WOB": "Weight on bit",
    "Omega": "Drive speed",
}
# Large values are shown in thousands.
_THOUSANDS = {"N.m": "kN.m", "N": "kN", "J": "kJ"}
_MOST_PANELS = 4
# A long chattering line is more than Agg can draw at once, and its own chunks leave gaps.
_LONGEST_LINE = 5000
# A title or name of any length would be laid out for minutes, off the page.
_LONGEST_TITLE, _LONGEST_NAME = 300, 80


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
    """Draw trajectories over time into a PNG file, which replaces one that is there when it is complete.

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
    shortened = {printable(name)[:_LONGEST_NAME]: result for name, result in results.items()}
    save_figure(path, lambda: _compose(printable(title)[:_LONGEST_TITLE], shortened, signals))


def save_figure(path: Path, compose: Callable[[], Any]) -> None:
    """Write a figure into a PNG file, which replaces one that is there when it is complete.

    Parameters
    ----------
    path : Path
        The file.
    compose : callable
        Makes the figure, whose texts are drawn as they stand.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    import matplotlib

    rc_context = cast(Any, matplotlib).rc_context
    drawn = io.BytesIO()
    # What is written is from files, and so no mathematics; and a font lacks some letters of all there are.
    with rc_context({"text.parse_math": False, "text.usetex": False}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        compose().savefig(drawn)
    replace_file(path, drawn.getvalue())


def _compose(title: str, results: Mapping[str, Result], signals: Sequence[str]) -> Any:
    """Lay out the panels."""
    first = next(iter(results.values()))
    shown = list(signals) or default_signals({name: first[name].dtype for name in first.names})
    rows, columns = max(1, len(shown)), len(results)
    figure = blank_figure(max(7.2, 3.6 * columns), 0.9 + 2.3 * rows)
    figure.suptitle(title, fontsize=12)
    panels = figure.subplots(rows, columns, sharex=True, sharey="row", squeeze=False)
    for row, name in enumerate(shown):
        for column, (variant, result) in enumerate(results.items()):
            panel = panels[row, column]
            _draw_panel(panel, result, name, _COLOURS[row % len(_COLOURS)])
            if column == 0:
                panel.set_ylabel(_label(name, result.units.get(name, "")))
                panel.set_title(f"{chr(ord('a') + row)})", loc="left", fontsize=10, fontweight="bold")
            if row == 0 and columns > 1:
                panel.set_title(variant, fontsize=10)
            if row == rows - 1:
                panel.set_xlabel("Time [s]")
    return figure


def blank_figure(width: float, height: float) -> Any:
    """Return a figure without panels, sizes in inches; matplotlib, which takes long to import, is only now."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=(width, height), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def default_signals(types: Mapping[str, np.dtype[Any]]) -> list[str]:
    """Choose by names and types what to show: bit speed and torque on bit, or else the first numbers recorded."""
    for name in types:
        component, _, variable = name.partition(".")
        if variable == "bit_speed" and f"{component}.bit_torque" in types:
            return [name, f"{component}.bit_torque"]
    return [name for name, dtype in types.items() if dtype == np.float64][:_MOST_PANELS]


def _draw_panel(panel: Any, result: Result, name: str, colour: str) -> None:
    """Draw one trajectory; strings as they follow each other, each at a height of its own."""
    values = result[name]
    if values.dtype != object:
        values = values / (1000.0 if result.units.get(name, "") in _THOUSANDS else 1.0)
    for first in range(0, max(1, values.size - 1), _LONGEST_LINE):
        part = slice(first, first + _LONGEST_LINE + 1)  # a point in common, so that the line has no gap
        panel.plot(result.time[part], values[part], color=colour, linewidth=0.9)
    panel.grid(visible=True, color="#d9d9d9", linewidth=0.5)
    panel.spines[["top", "right"]].set_visible(False)
    panel.margins(x=0.0)


def _label(name: str, unit: str) -> str:
    """Write the label of an axis."""
    variable = name.partition(".")[2]
    shown = _THOUSANDS.get(unit, printable(unit)[:_LONGEST_NAME])
    text = _NAMES.get(variable, printable(name)[:_LONGEST_NAME])
    return f"{text} [{shown}]" if shown and shown != "1" else text
