"""Scenarios as TOML files; every key that is not known is refused."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, cast

from cosim.errors import InputError, ScenarioError, suggestion
from cosim.scenario.scenario import Scenario, Variant
from cosim.scenario.signal_file import read_signal
from cosim.scenario.toml_table import TomlTable
from cosim.system.method import Method
from cosim.system.signals import Value
from cosim.system.structure import Component, Connection, PowerBond, System

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"

_KEYS = (
    "title", "description", "start_time", "stop_time", "step_size", "algorithm", "order", "tolerance", "on_failure",
    "iteration_tolerance", "components", "connections", "inputs", "guards", "power_bonds", "variants", "figure",
)  # fmt: skip


def scenario_names() -> tuple[str, ...]:
    """Return the names of the scenarios that come with the package."""
    return tuple(sorted(path.stem for path in SCENARIOS.glob("*.toml")))


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Load a scenario that comes with the package, or one from a TOML file.

    Parameters
    ----------
    name_or_path : str or Path
        A name such as ``"stick-slip"``, or the path of a file that ends in ``.toml``.

    Raises
    ------
    ScenarioError
        If it does not exist, is not TOML, or holds a key or value that is not understood.
    SystemDefinitionError
        If its components and connections contradict each other.
    """
    path = Path(name_or_path)
    if path.suffix != ".toml":
        path = SCENARIOS / f"{name_or_path}.toml"
        if str(name_or_path) not in scenario_names():
            hint = suggestion(str(name_or_path), scenario_names())
            hint = hint or "; a file name must end in .toml or .ssp"
            raise ScenarioError(f"there is no scenario '{name_or_path}'{hint}")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ScenarioError(f"{path}: there is no such file") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ScenarioError(f"{path}: cannot be read: {error}") from error
    try:
        return _scenario(content, path)
    except InputError as error:
        raise type(error)(f"{path.name}: {error}") from error


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
        stop_time=table.number("stop_time"),
        step_size=table.number("step_size"),
        start_time=table.number("start_time", 0.0),
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
    """Build a connection from ``{ from = ..., to = ... }``."""
    table = TomlTable(content, "connections", ("from", "to"))
    return Connection(table.text("from"), table.text("to"))


def _power_bond(content: object) -> PowerBond:
    """Build a power bond from ``{ input = ..., output = ... }``."""
    table = TomlTable(content, "power_bonds", ("input", "output"))
    return PowerBond(table.text("input"), table.text("output"))


def _variant(content: object, folder: Path) -> Variant:
    """Build a variant from ``[[variants]]``."""
    table = TomlTable(content, "variants", ("name", "set"))
    values = table.variables("set")
    return Variant(table.text("name"), {key: _value(value, values.path(key), folder) for key, value in values.items()})


def _value(content: object, where: str, folder: Path) -> Value:
    """Take a plain value, or the path of a file written ``{ file = "..." }``, relative to the scenario."""
    if isinstance(content, bool | int | float | str):
        return content
    if not isinstance(content, dict):
        raise ScenarioError(f"{where} is {content!r}; expected a number, true, false, a string or {{ file = ... }}")
    path = folder / TomlTable(cast(object, content), where, ("file",)).text("file")
    if not path.is_file():
        raise ScenarioError(f"{where}: {path}: there is no such file")
    return str(path)
