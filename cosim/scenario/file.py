"""Load scenarios by name, or from TOML files, in which a key that is not known is refused.

`TomlTable` knows where in the file it stands, so that every complaint names the key.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from cosim.errors import InputError, ScenarioError, suggestion
from cosim.files import read_file
from cosim.scenario.scenario import Scenario, Variant
from cosim.system.field_units import in_unit, quantity
from cosim.system.method import Method
from cosim.system.signals import Constant, Ramp, Signal, Step, Table, Value, ramp, table_of_points
from cosim.system.staircase import staircase_of_points
from cosim.system.structure import Component, Connection, PowerBond, System
from cosim.system.table_file import GAPS, read_column

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"

MOST_BYTES = 2**26
"""In a scenario file."""
_LONGEST_PATH = 1024
_KEYS = (
    "title", "description", "start_time", "stop_time", "step_size", "algorithm", "order", "tolerance", "on_failure",
    "iteration_tolerance", "components", "connections", "inputs", "guards", "power_bonds", "variants", "figure",
)  # fmt: skip


def scenario_names() -> tuple[str, ...]:
    """Return the names of the scenarios that come with the package.

    Returns
    -------
    tuple of str
        In alphabetical order, each to be given to `load_scenario`.
    """
    return tuple(sorted(path.stem for path in SCENARIOS.glob("*.toml")))


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Load a scenario that comes with the package, or one from a TOML file.

    Parameters
    ----------
    name_or_path : str or Path
        A name such as ``"stick-slip"``, or the path of a file that ends in ``.toml``.

    Returns
    -------
    Scenario
        To be given to `cosim.simulate`, or to be changed first.

    Raises
    ------
    ScenarioError
        If it does not exist, is not TOML, or holds a key or value that is not understood.
    SystemDefinitionError
        If its components and connections contradict each other.
    """
    if not isinstance(cast(object, name_or_path), str | Path):
        raise ScenarioError(f"scenario is {name_or_path!r}; expected a name or path of one")
    path = Path(name_or_path)
    if path.suffix == ".ssp":
        raise ScenarioError(
            f"{path}: the FMUs of an .ssp file are unpacked for as long as it is run; expected it to be given to "
            "simulate or stream by its path"
        )
    if path.suffix != ".toml":
        path = SCENARIOS / f"{name_or_path}.toml"
        if str(name_or_path) not in scenario_names():
            hint = suggestion(str(name_or_path), scenario_names())
            hint = hint or "; a file name must end in .toml, .ssp or .ssd"
            raise ScenarioError(f"there is no scenario '{name_or_path}'{hint}")
    content = read_toml(path)
    try:
        return _scenario(content, path)
    except InputError as error:
        raise type(error)(f"{path.name}: {error}") from error


def read_toml(path: Path) -> dict[str, Any]:
    """Read a file of TOML, whose integers have 64 bits, and which is nested as deep as Python can follow."""
    try:
        content = tomllib.loads(read_file(path, MOST_BYTES).decode("utf-8-sig"))
    except FileNotFoundError:
        raise ScenarioError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:  # ValueError of integers that are longer than Python reads, too
        raise ScenarioError(f"{path}: cannot be read: {error}") from error
    except RecursionError:
        raise ScenarioError(f"{path}: cannot be read: it is nested too deep") from None
    left: list[Any] = [content]
    while left:
        value = left.pop()
        if isinstance(value, int) and not -(2**63) <= value < 2**63:
            raise ScenarioError(f"{path}: an integer is {_shortened(value)}; expected one of 64 bits, as TOML has it")
        if isinstance(value, dict | list):
            left.extend(cast(dict[str, Any], value).values() if isinstance(value, dict) else cast(list[Any], value))
    return content


def _shortened(number: int) -> str:
    """Write a number of any length in little room."""
    return f"{'-' if number < 0 else ''}0x{abs(number):x}" if abs(number) < 2**80 else f"of {number.bit_length()} bits"


def _scenario(content: dict[str, Any], path: Path) -> Scenario:
    """Build a scenario from the whole file."""
    table = TomlTable(content, "", _KEYS)
    folder = path.resolve().parent
    parts = table.table("components")
    system = System(
        components=tuple(_component(name, value, parts.path(name), folder) for name, value in parts.items()),
        connections=tuple(_connection(value) for value in table.array("connections")),
        inputs={
            name: read_signal(value, f"inputs.{name}", folder) for name, value in table.variables("inputs").items()
        },
        guards=table.texts("guards") if "guards" in table else None,
        power_bonds=tuple(map(_power_bond, table.array("power_bonds"))) if "power_bonds" in table else None,
    )
    return Scenario(
        name=path.stem,
        system=system,
        stop_time=table.seconds("stop_time"),
        step_size=table.seconds("step_size"),
        start_time=table.seconds("start_time", 0.0),
        method=_method(table),
        title=table.text("title", ""),
        description=table.text("description", "").strip(),
        variants=tuple(_variant(value, folder) for value in table.array("variants")),
        signals=table.table("figure", ("signals",)).texts("signals"),
        folder=folder,
    )


def _method(table: TomlTable) -> Method:
    """Read how to step; what the file leaves out is as in `Method`."""
    usual = Method()
    return Method(
        algorithm=table.text("algorithm", usual.algorithm),
        order=table.texts("order"),
        tolerance=table.number("tolerance") if "tolerance" in table else None,
        on_failure=table.text("on_failure", usual.on_failure),
        iteration_tolerance=table.number("iteration_tolerance", usual.iteration_tolerance),
    )


def _component(name: str, content: object, where: str, folder: Path) -> Component:
    """Build a component from ``[components.<name>]``."""
    table = TomlTable(content, where, ("fmu", "parameters", "isolate"))
    given = table.table("parameters")
    parameters = {key: _value(value, given.path(key), folder) for key, value in given.items()}
    return Component(name, table.text("fmu"), parameters, table.boolean("isolate", default=False))


def _connection(content: object) -> Connection:
    """Build a connection from ``{ from = ..., to = ... }``, and what becomes of its values on the way."""
    table = TomlTable(content, "connections", ("from", "to", "factor", "offset", "table", "unconverted"))
    return Connection(
        table.text("from"),
        table.text("to"),
        unconverted=table.boolean("unconverted", default=False),
        factor=table.number("factor", 1.0),
        offset=table.number("offset", 0.0),
        table={_key(key): _level(value, key) for key, value in table.table("table").items()},
    )


def _key(key: str) -> Value:
    """Return what a key of a connection's table stands for: true, false, a whole number or the name of an item."""
    if key in ("true", "false"):
        return key == "true"
    return int(key) if re.fullmatch(r"[+-]?\d+", key) else key


def _level(value: object, key: str) -> Value:
    """Take what a connection's table holds for a key."""
    if isinstance(value, bool | int | str):
        return value
    raise ScenarioError(f"connections.table.{key} is {value!r}; expected true, false, a whole number or an item's name")


def _power_bond(content: object) -> PowerBond:
    """Build a power bond from ``{ input = ..., output = ... }``."""
    table = TomlTable(content, "power_bonds", ("input", "output"))
    return PowerBond(table.text("input"), table.text("output"))


def _variant(content: object, folder: Path) -> Variant:
    """Build a variant from ``[[variants]]``."""
    table = TomlTable(content, "variants", ("name", "set"))
    values = table.variables("set")
    return Variant(
        table.text("name"), {key: _setting(value, values.path(key), folder) for key, value in values.items()}
    )


def _setting(content: object, where: str, folder: Path) -> Value | Signal:
    """Take what a variant sets: a value, or a signal written as among the inputs."""
    if isinstance(content, dict) and "kind" in content:
        return read_signal(cast(object, content), where, folder)
    return _value(cast(object, content), where, folder)


def _value(content: object, where: str, folder: Path) -> Value:
    """Take a plain value, or the path of a file written ``{ file = "..." }``, relative to the scenario."""
    if isinstance(content, str):
        return _beside(content, folder)
    if isinstance(content, bool | int | float):
        return content
    if not isinstance(content, dict):
        raise ScenarioError(f"{where} is {content!r}; expected a number, true, false, a string or {{ file = ... }}")
    path = folder / TomlTable(cast(object, content), where, ("file",)).text("file")
    if not path.is_file():
        raise ScenarioError(f"{where}: {path}: there is no such file")
    return str(path)


def _beside(text: str, folder: Path) -> str:
    """Return the full path where a string is that of a file beside the scenario, as it stands, else the string."""
    if not Path(text).suffix or len(text) > _LONGEST_PATH or "\0" in text:
        return text
    path = folder / text
    return str(path) if path.is_file() else text


@contextmanager
def opened_scenario(
    source: Scenario | str | Path, stop_time: float | None = None, step_size: float | None = None
) -> Generator[Scenario]:
    """Load a scenario for as long as it is needed.

    Parameters
    ----------
    source : Scenario, str or Path
        A name such as ``"stick-slip"``, or the path of a .toml or .ssp file; a scenario is taken as it is.
    stop_time, step_size : float, optional
        In s; for .ssp files that do not give them.

    Raises
    ------
    InputError
        If there is none, or it cannot be understood.
    """
    if isinstance(source, Scenario):
        yield source
        return
    if not isinstance(cast(object, source), str | Path):
        raise ScenarioError(f"scenario is {source!r}; expected a Scenario, or a name or path of one")
    if Path(source).suffix not in (".ssp", ".ssd"):
        yield load_scenario(source)
        return
    from cosim.scenario.ssp.reading import open_ssp  # with fmpy and lxml, which a TOML file does without

    with open_ssp(source, stop_time=stop_time, step_size=step_size) as loaded:
        yield loaded


_OF_POINTS = ("unit", "factor")
_OF_FILES = ("column", "time", "separator", "decimal", "gaps")

_SIGNAL_KEYS = {
    Step.kind: Step.parts(),
    Ramp.kind: Ramp.parts(),
    Table.kind: ("points", "file", *_OF_POINTS, *_OF_FILES),
}


def read_signal(content: object, where: str, folder: Path) -> Signal:
    """Build a signal from a number, a Boolean, a string, or a table with a kind.

    Parameters
    ----------
    content : object
        What the TOML reader returned, such as ``{"kind": "step", "before": 1, "after": 2, "at": 5}``.
    where : str
        Path of keys that leads to it.
    folder : Path
        Folder that the path of a CSV file starts from.

    Raises
    ------
    ScenarioError
        If it is not understood.
    """
    if isinstance(content, bool | int | float | str):
        return Constant(content)
    if not isinstance(content, dict):
        raise ScenarioError(f"{where} is {content!r}; expected a number, true, false, a string or a table with a kind")
    kind = TomlTable(cast(object, content), where).text("kind")
    if kind not in _SIGNAL_KEYS:
        raise ScenarioError(f"{where}.kind is '{kind}'{suggestion(kind, _SIGNAL_KEYS)}")
    table = TomlTable(cast(object, content), where, ("kind", *_SIGNAL_KEYS[kind]))
    build: dict[str, Callable[[], Signal]] = {
        Step.kind: lambda: Step(table.level("before"), table.level("after"), table.seconds("at")),
        Ramp.kind: lambda: _ramp(table),
        Table.kind: lambda: _points(table, folder),
    }
    try:
        return build[kind]()
    except ScenarioError as error:
        message = str(error)
        raise ScenarioError(message if where in message else f"{where}: {message}") from None


def _ramp(table: TomlTable) -> Signal:
    """Build a ramp, whose values may be in a unit: both as numbers with it, or both in that of the key ``unit``."""
    (initial, unit), (final, other) = (table.quantity(key) for key in ("initial", "final"))
    if unit != other or (unit and "unit" in table):
        told = ", ".join(f"'{each}'" if each else "none" for each in (unit, other))
        raise ScenarioError(f"the values are in the units {told}; expected one unit, once, or with both of them")
    unit = unit or table.text("unit", "")
    found = ramp(initial, final, table.seconds("start"), table.seconds("duration"))
    if not unit:
        return found
    if isinstance(found, Ramp):
        return replace(found, unit=unit)
    return Step(f"{initial!r} {unit}", f"{final!r} {unit}", found.at)  # its levels are read as numbers with units


def _points(table: TomlTable, folder: Path) -> Signal:
    """Build a table from points in place or from a CSV file beside the scenario."""
    if ("points" in table) == ("file" in table):
        raise ScenarioError("expected either points or file")
    factor = table.number("factor") if "factor" in table else None
    if "file" in table:
        return read_column(
            folder / table.text("file"),
            table.text("column", "") or None,
            time=table.text("time", "") or None,
            unit=table.text("unit") if "unit" in table else None,
            factor=factor,
            separator=table.text("separator") if "separator" in table else None,
            decimal=table.text("decimal", "."),
            gaps=table.text("gaps", GAPS[0]),
        ).as_far_as_known()
    for key in _OF_FILES:
        if key in table:
            raise ScenarioError(f"{key} is for a file; expected points without it")
    points = [_pair(pair) for pair in table.array("points")]
    if not any(isinstance(value, bool | str) for _, value in points):
        numbers = cast(list[tuple[float, float]], points)
        return table_of_points(numbers, table.text("unit", ""), 1.0 if factor is None else factor)
    for key in _OF_POINTS:
        if key in table:
            raise ScenarioError(f"{key} is for numbers; expected points without it")
    return staircase_of_points(points)


def _pair(content: object) -> tuple[float, Value]:
    """Take a point of a table."""
    match content:
        case [int() | float() as time, bool() | int() | float() | str() as value] if not isinstance(time, bool):
            return time, value
        case _:
            raise ScenarioError(f"points hold {content!r}; expected pairs of a time in s and a value")


class TomlTable:
    """A table whose keys are taken one by one, each with the type it must have.

    Parameters
    ----------
    content : object
        What the TOML reader returned.
    where : str
        Path of keys that leads to it, empty for the whole file.
    known : collection of str, optional
        The keys it may have; by default any.

    Raises
    ------
    ScenarioError
        If it is no table or has another key.
    """

    def __init__(self, content: object, where: str, known: Collection[str] | None = None) -> None:
        if not isinstance(content, dict):
            raise ScenarioError(f"{where} is {content!r}; expected a table")
        self.where = where
        self._content = cast(dict[str, Any], content)
        for key in self._content:
            if known is not None and key not in known:
                raise ScenarioError(f"unknown key '{self.path(key)}'{suggestion(key, known)}")

    def path(self, key: str) -> str:
        """Return the full path of a key."""
        return f"{self.where}.{key}" if self.where else key

    def __contains__(self, key: str) -> bool:
        return key in self._content

    def items(self) -> Iterator[tuple[str, object]]:
        """Go through keys and values, as they are."""
        yield from self._content.items()

    def text(self, key: str, default: str | None = None) -> str:
        """Take a string."""
        value = self._get(key, default)
        if not isinstance(value, str):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected a string")
        return value

    def number(self, key: str, default: float | None = None) -> float:
        """Take a number."""
        value = self._get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected a number")
        return float(value)

    def quantity(self, key: str) -> tuple[float, str]:
        """Take a number, or one with a unit, as ``"120 rpm"``; the unit is empty where there is none."""
        value = self._get(key, None)
        found = quantity(value) if isinstance(value, str) else (self.number(key), "")
        if found is None:
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected a number, or one with a unit")
        return found

    def seconds(self, key: str, default: float | None = None) -> float:
        """Take a time in s, or in a unit that it names, as ``"2 min"``."""
        value = self._get(key, default)
        if not isinstance(value, str):
            return self.number(key, default)
        if quantity(value) is None:
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected a number, or one with a unit, as '2 min'")
        return in_unit(value, "s", self.path(key))

    def boolean(self, key: str, *, default: bool) -> bool:
        """Take a Boolean."""
        value = self._get(key, default)
        if not isinstance(value, bool):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected true or false")
        return value

    def level(self, key: str) -> Value:
        """Take a number, a Boolean or a string, as it is."""
        value = self._get(key, None)
        if not isinstance(value, int | float | str):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected a number, true, false or a string")
        return value

    def array(self, key: str) -> list[object]:
        """Take an array; none is an empty one."""
        value = self._content.get(key, [])
        if not isinstance(value, list):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected an array")
        return cast(list[object], value)

    def texts(self, key: str) -> tuple[str, ...]:
        """Take an array of strings; none is an empty one."""
        values = self.array(key)
        for value in values:
            if not isinstance(value, str):
                raise ScenarioError(f"{self.path(key)} holds {value!r}; expected strings")
        return tuple(map(str, values))

    def table(self, key: str, known: Collection[str] | None = None) -> TomlTable:
        """Take a table; none is an empty one."""
        return TomlTable(self._content.get(key, {}), self.path(key), known)

    def variables(self, key: str) -> TomlTable:
        """Take a table by ``component.variable``; ``plant.WOB = 1`` means the same as ``"plant.WOB" = 1``."""
        flat: dict[str, Any] = {}
        for name, value in self.table(key).items():
            if "." in name or not isinstance(value, dict):
                flat[name] = value
            else:
                inner = cast(dict[str, object], value)
                flat.update({f"{name}.{variable}": content for variable, content in inner.items()})
        return TomlTable(flat, self.path(key))

    def _get(self, key: str, default: object) -> object:
        """Take a value of any type, which must be there if there is no default."""
        if key not in self._content and default is None:
            raise ScenarioError(f"'{self.path(key)}' is missing")
        return self._content.get(key, default)
