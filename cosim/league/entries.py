"""Read which laws are judged, and under which conditions, from a TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import TypeVar

from cosim.errors import InputError, ScenarioError, suggestion
from cosim.fmi2.locate import locate_fmu
from cosim.scenario.file import TomlTable, read_toml
from cosim.scenario.parameters import load_parameters
from cosim.system.signals import Value

LEAGUES = Path(__file__).resolve().parents[1] / "leagues"
Entry = TypeVar("Entry")

USUAL = LEAGUES / "field.toml"
"""The league that comes with the package."""


@dataclass(frozen=True)
class Law:
    """Describe one law that is judged.

    Attributes
    ----------
    name, title : str
        Short, and for people.
    fmu : str
        A name, or the path of an .fmu file; empty for the drive alone.
    parameters, drive : mapping of str to value
        Parameters of the law, and of the drive it works with.
    """

    name: str
    title: str
    fmu: str = ""
    parameters: Mapping[str, Value] = field(default_factory=dict[str, Value])
    drive: Mapping[str, Value] = field(default_factory=dict[str, Value])


@dataclass(frozen=True)
class Condition:
    """State what laws are judged under.

    Attributes
    ----------
    name, title : str
        Short, and for people.
    speed, weight : float
        Rotation [rad/s] and weight on bit [N] asked for.
    plant, drive : mapping of str to value
        Parameters of the string, which the laws know, and of the drive, which they do not.
    assumed : mapping of str to float
        What laws take a parameter of the string for, as a multiple of what it is.
    load_time : float
        If positive, the law acts from the start, and the weight rises from zero meanwhile [s].
    hard : bool
        Some good laws are known to fail here.
    """

    name: str
    title: str
    speed: float
    weight: float
    plant: Mapping[str, Value] = field(default_factory=dict[str, Value])
    drive: Mapping[str, Value] = field(default_factory=dict[str, Value])
    assumed: Mapping[str, float] = field(default_factory=dict[str, float])
    load_time: float = 0.0
    hard: bool = False


@dataclass(frozen=True)
class Search:
    """Make a quantity worse until a law fails.

    Attributes
    ----------
    name, title : str
        Short, and for people; the title says the unit.
    condition : Condition
        What all else is like.
    vary : str
        ``speed``, ``weight``, or a parameter of the drive as ``drive.<name>``.
    values : tuple of float
        From the easiest on.
    """

    name: str
    title: str
    condition: Condition
    vary: str
    values: tuple[float, ...]

    def at(self, value: float) -> Condition:
        """Return the condition with another value."""
        if self.vary.startswith("drive."):
            drive = {**self.condition.drive, self.vary.removeprefix("drive."): value}
            return replace(self.condition, drive=drive)
        return replace(self.condition, **{self.vary: value})


@dataclass(frozen=True)
class Range:
    """Bound a parameter that `cosim tune` sets free.

    Attributes
    ----------
    low, high : float
        Least and greatest value.
    times : bool
        They are multiples of what the law has of itself, by formula or as a start value.
    """

    low: float
    high: float
    times: bool = False


@dataclass(frozen=True)
class League:
    """Hold laws, conditions, and how long each run is.

    Attributes
    ----------
    title : str
        For people.
    settle, judge : float
        How long stick-slip settles before a law is switched on, and how long it is judged then [s].
    step_size : float
        Communication step size [s].
    laws, conditions, searches : tuple
        In the order of the file.
    folder : Path
        Where relative paths of FMUs start from.
    tunes : mapping of str to mapping of str to Range
        What tuning sets free, by the name of a law or of its FMU, and by parameter.
    """

    title: str
    settle: float
    judge: float
    step_size: float
    laws: tuple[Law, ...]
    conditions: tuple[Condition, ...]
    searches: tuple[Search, ...]
    folder: Path
    tunes: Mapping[str, Mapping[str, Range]] = field(default_factory=dict[str, Mapping[str, Range]])

    def only(self, laws: list[str], conditions: list[str]) -> League:
        """Return the league with some laws and conditions only; all where none are named.

        Raises
        ------
        ScenarioError
            If there is none of a name.
        """
        chosen = _chosen("condition", {each.name: each for each in self.conditions}, conditions)
        searches = () if conditions else self.searches
        return replace(
            self,
            laws=_chosen("law", {each.name: each for each in self.laws}, laws),
            conditions=chosen,
            searches=searches,
        )


def load_league(path: Path = USUAL, more: list[Path] | None = None, parameters: list[Path] | None = None) -> League:
    """Read a league.

    Parameters
    ----------
    path : Path
        A TOML file; by default the league that comes with the package.
    more : list of Path, optional
        FMUs that take part besides, with their start values, each under the name of its file.
    parameters : list of Path, optional
        Parameter files of laws that take part besides, as `cosim tune` writes them.

    Raises
    ------
    ScenarioError
        If the file cannot be read, or holds what is not understood.
    """
    content = read_toml(path)
    try:
        league = _league(content, path.resolve().parent)
    except InputError as error:
        raise type(error)(f"{path.name}: {error}") from error
    added = {str(each): Law(each.stem, each.stem, str(each.resolve())) for each in more or ()}
    added |= {str(each): _with_parameters(each) for each in parameters or ()}
    taken = {law.name for law in league.laws}
    for file, law in added.items():
        if law.name in taken:
            raise ScenarioError(f"{file}: there is a law '{law.name}' already; expected another name")
        taken.add(law.name)
    return replace(league, laws=(*league.laws, *added.values()))


def _with_parameters(path: Path) -> Law:
    """Build a law from a parameter file."""
    from cosim.fmi2.model_description import read_description  # with fmpy, which lists of laws do without

    file = load_parameters(path)
    file.refuse_unfit("law", read_description(locate_fmu(file.fmu, "native")))
    return Law(file.name, file.title, file.fmu, file.values, file.drive)


def _league(content: dict[str, object], folder: Path) -> League:
    """Build a league from the whole file."""
    keys = ("title", "settle", "judge", "step_size", "laws", "conditions", "searches", "tunes")
    table = TomlTable(content, "", keys)
    laws, conditions, searches, tunes = (table.table(key) for key in keys[4:])
    known = {name: _condition(name, value, conditions.path(name)) for name, value in conditions.items()}
    league = League(
        title=table.text("title", ""),
        settle=_positive(table, "settle"),
        judge=_positive(table, "judge"),
        step_size=_positive(table, "step_size"),
        laws=tuple(_law(name, value, laws.path(name)) for name, value in laws.items()),
        conditions=tuple(known.values()),
        searches=tuple(_search(name, value, searches.path(name), known) for name, value in searches.items()),
        folder=folder,
        tunes={name: _ranges(tunes.table(name)) for name, _ in tunes.items()},
    )
    if not league.laws or not league.conditions:
        raise ScenarioError("expected at least one law and one condition")
    return league


def _positive(table: TomlTable, key: str) -> float:
    """Take a number above zero."""
    value = table.number(key)
    if not value > 0.0:
        raise ScenarioError(f"{table.path(key)} is {value:g}; expected a number > 0")
    return value


def _law(name: str, content: object, where: str) -> Law:
    """Build a law from ``[laws.<name>]``."""
    table = TomlTable(content, where, ("title", "fmu", "parameters", "drive"))
    parameters, drive = (_levels(table.table(key)) for key in ("parameters", "drive"))
    return Law(name, table.text("title", name), table.text("fmu", ""), parameters, drive)


def _condition(name: str, content: object, where: str) -> Condition:
    """Build a condition from ``[conditions.<name>]``."""
    keys = ("title", "speed", "weight", "plant", "drive", "assumed", "load_time", "hard")
    table = TomlTable(content, where, keys)
    assumed = table.table("assumed")
    return Condition(
        name,
        table.text("title", name),
        table.number("speed"),
        table.number("weight"),
        _levels(table.table("plant")),
        _levels(table.table("drive")),
        {key: assumed.number(key) for key, _ in assumed.items()},
        table.number("load_time", 0.0),
        table.boolean("hard", default=False),
    )


def _search(name: str, content: object, where: str, conditions: Mapping[str, Condition]) -> Search:
    """Build a search from ``[searches.<name>]``."""
    table = TomlTable(content, where, ("title", "condition", "vary", "values"))
    vary, condition = table.text("vary"), table.text("condition")
    if vary not in ("speed", "weight") and not vary.startswith("drive."):
        raise ScenarioError(f"{table.path('vary')} is '{vary}'; expected speed, weight or drive.<parameter>")
    if condition not in conditions:
        raise ScenarioError(f"{where}: there is no condition '{condition}'{suggestion(condition, conditions)}")
    values: list[float] = []
    for value in table.array("values"):
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ScenarioError(f"{table.path('values')} holds {value!r}; expected numbers")
        values.append(float(value))
    return Search(name, table.text("title", name), conditions[condition], vary, tuple(values))


def _ranges(table: TomlTable) -> dict[str, Range]:
    """Build the ranges of ``[tunes.<name>]``: ``[low, high]``, or ``{ times = [low, high] }``."""
    found: dict[str, Range] = {}
    for name, value in table.items():
        holder = table.table(name, ("times",)) if isinstance(value, dict) else table
        key = name if holder is table else "times"
        bounds = holder.array(key)
        numbers = [float(each) for each in bounds if isinstance(each, int | float) and not isinstance(each, bool)]
        if len(bounds) != 2 or len(numbers) != 2:
            raise ScenarioError(f"{holder.path(key)} is {bounds!r}; expected two numbers, the least and the greatest")
        found[name] = checked_range(Range(*numbers, times=holder is not table), holder.path(key))
    return found


def checked_range(bounds: Range, where: str) -> Range:
    """Return a range; ScenarioError if it leaves nothing free."""
    if not (isfinite(bounds.low) and isfinite(bounds.high)):
        raise ScenarioError(f"{where} goes from {bounds.low:g} to {bounds.high:g}; expected finite numbers")
    if not bounds.low < bounds.high:
        raise ScenarioError(f"{where} goes from {bounds.low:g} to {bounds.high:g}; expected the lesser number first")
    return bounds


def _levels(table: TomlTable) -> dict[str, Value]:
    """Take values by name."""
    return {key: table.level(key) for key, _ in table.items()}


def _chosen(what: str, entries: Mapping[str, Entry], names: list[str]) -> tuple[Entry, ...]:
    """Return the entries of these names, all of them if there are none."""
    for name in names:
        if name not in entries:
            raise ScenarioError(f"there is no {what} '{name}'{suggestion(name, entries)}")
    return tuple(entry for name, entry in entries.items() if not names or name in names)
