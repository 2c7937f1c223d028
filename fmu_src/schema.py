"""Define what one row of an interface table can say: variables, units and models as plain frozen data.

The words are those of the FMI 2.0 standard (section 2.2.7 for variables, 2.2.2 for units).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import Literal

Causality = Literal["input", "output", "parameter"]
Kind = Literal["Real", "Integer", "Boolean", "String", "Enumeration"]
Variability = Literal["fixed", "tunable", "discrete", "continuous"]
Value = float | int | bool | str

LOG_CATEGORIES: tuple[tuple[str, str], ...] = (
    ("logEvents", "Stops and releases of the bit, guards and limits of the laws, as they happen."),
    ("logStatusWarning", "What limits the worth of the results."),
    ("logStatusDiscard", "Messages that come with fmi2Discard: which variable, its value, the expected range."),
    ("logStatusError", "Messages that come with fmi2Error; they are told always."),
    ("logAll", "All messages."),
)


class Packaging(StrEnum):
    """Name the ways in which a computation is put into an FMU."""

    NATIVE = "native"
    PYTHON = "python"


@dataclass(frozen=True)
class DisplayUnit:
    """A unit for the reader's eye: shown value = factor * SI value."""

    name: str
    factor: float


@dataclass(frozen=True)
class Unit:
    """An SI unit by its exponents of kg, m, s and rad, with the display units a tool may offer."""

    name: str
    kg: int = 0
    m: int = 0
    s: int = 0
    rad: int = 0
    display: tuple[DisplayUnit, ...] = ()


@dataclass(frozen=True)
class Variable:
    """One scalar variable of an FMU; its value reference is its place in the table.

    Attributes
    ----------
    dependencies : tuple of str, optional
        Outputs only: the inputs the output depends on directly at a communication point.
    initial_dependencies : tuple of str, optional
        Outputs only: inputs and parameters its value after initialisation depends on.
    equation : str
        Where the quantity is defined, or an input enters: an equation of the paper, or the page of this project.
    items : tuple of str
        Enumerations only: the names of the values 1, 2, ...
    """

    name: str
    causality: Causality
    description: str
    kind: Kind = "Real"
    variability: Variability = "continuous"
    unit: str | None = None
    display: str | None = None
    start: Value | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    equation: str = ""
    dependencies: tuple[str, ...] = ()
    initial_dependencies: tuple[str, ...] = ()
    items: tuple[str, ...] = ()

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and the greatest value allowed; infinite where there is no limit."""
        if self.kind == "Boolean":
            return 0.0, 1.0
        if self.kind == "Enumeration":
            return 1.0, float(len(self.items))
        low, high = self.minimum, self.maximum
        return (-inf if low is None else float(low)), (inf if high is None else float(high))


@dataclass(frozen=True)
class Terminal:
    """Signals that belong together; terminals of one name fit each other (FMI 3.0, section 2.4.9).

    Attributes
    ----------
    members : tuple of str
        Variables; the terminal is named for the first.
    color : str
        Of the line a tool draws to it: red, green and blue, each from 0 to 255.
    """

    name: str
    description: str
    members: tuple[str, ...]
    color: str


@dataclass(frozen=True)
class Model:
    """One FMU: its table of variables and what its modelDescription.xml says beside them.

    Attributes
    ----------
    step_size : float
        Communication step size of the default experiment [s].
    equations : tuple of (str, str)
        Headings and HTML text of the documentation page.
    use, limits : tuple of str
        Items of the documentation page, HTML: how to use the FMU, and where it ends to hold.
    verdict : str
        What a reader of the documentation page must not miss, HTML; empty if there is nothing.
    """

    name: str
    description: str
    variables: tuple[Variable, ...]
    stop_time: float = 100.0
    step_size: float = 0.01
    log_categories: tuple[tuple[str, str], ...] = LOG_CATEGORIES
    equations: tuple[tuple[str, str], ...] = ()
    use: tuple[str, ...] = ()
    limits: tuple[str, ...] = field(default=())
    verdict: str = ""
    terminals: tuple[Terminal, ...] = ()

    def value_reference(self, name: str) -> int:
        """Return the value reference of a variable; KeyError if the table has no such name."""
        for index, variable in enumerate(self.variables):
            if variable.name == name:
                return index
        raise KeyError(f"{self.name} has no variable {name!r}")

    def select(self, causality: Causality) -> tuple[Variable, ...]:
        """Return the variables of one causality, in table order."""
        return tuple(v for v in self.variables if v.causality == causality)

    @property
    def has_real_inputs(self) -> bool:
        """Tell whether derivatives of inputs, and by inputs, have a meaning."""
        return any(variable.kind == "Real" for variable in self.select("input"))
