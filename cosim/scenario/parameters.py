"""Read and write parameter files: values of one FMU's parameters, by name, in TOML, for scenarios and leagues.

    fmu = "SoftTorque"

    [parameters]
    mode = "own"
    P = 512.3

`cosim tune` writes them, with the drive that the law was tuned with and where the values come from; by hand the two
tables above are enough.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cosim.errors import InputError, ScenarioError, suggestion
from cosim.fmi2.locate import locate_fmu
from cosim.scenario.file import TomlTable, read_toml
from cosim.scenario.scenario import Scenario
from cosim.system.description import Description
from cosim.system.signals import Value
from cosim.system.structure import Component, System

_KEYS = ("name", "title", "fmu", "component", "parameters", "drive", "provenance")


@dataclass(frozen=True)
class ParameterFile:
    """Hold the values of an FMU's parameters.

    Attributes
    ----------
    path : Path
        The file.
    fmu : str
        A name, or the path of an .fmu file.
    values, drive : mapping of str to value
        Parameters of the FMU and, for a league, of the drive that it works with.
    name, title : str
        In a league: short, and for people.
    component : str
        Of a scenario; empty for the one that is this FMU.
    """

    path: Path
    fmu: str
    values: Mapping[str, Value]
    drive: Mapping[str, Value] = field(default_factory=dict[str, Value])
    name: str = ""
    title: str = ""
    component: str = ""

    @property
    def model(self) -> str:
        """The name of the FMU."""
        return Path(self.fmu).stem

    def overrides(self, scenario: Scenario, packaging: str) -> dict[str, Value]:
        """Return the values by ``component.variable``.

        Raises
        ------
        InputError
            If the scenario has no such component, or more than one; or a name or value does not fit.
        """
        from cosim.fmi2.model_description import read_description  # with fmpy, which reading a file does without

        known: dict[str, Description] = {}
        fitting: list[str] = []
        for part in scenario.system.components:
            if callable(part.fmu):
                continue
            path = locate_fmu(part.fmu, packaging, scenario.folder)
            known[part.name] = read_description(path)
            if self.model in (known[part.name].model_name, path.stem):
                fitting.append(part.name)
        component = self._component(scenario.name, known, fitting)
        self.refuse_unfit(component, known[component])
        return {f"{component}.{name}": value for name, value in self.values.items()}

    def _component(self, scenario: str, known: Mapping[str, Description], fitting: list[str]) -> str:
        """Return the name of the component that the values are for, of those that are this FMU."""
        if self.component and self.component not in known:
            hint = suggestion(self.component, known)
            raise ScenarioError(f"{self.path}: {scenario} has no component '{self.component}'{hint}")
        if self.component and self.component not in fitting:
            other = f"component '{self.component}' of {scenario} is {known[self.component].model_name}"
            raise ScenarioError(f"{self.path} holds parameters of {self.model}; {other}")
        if not fitting:
            has = ", ".join(sorted({described.model_name for described in known.values()}))
            raise ScenarioError(f"{self.path} holds parameters of {self.model}; {scenario} couples {has}")
        if len(fitting) > 1 and not self.component:
            which = f"{' and '.join(fitting)} of {scenario} are both {self.model}"
            raise ScenarioError(f'{self.path}: {which}; expected component = "{fitting[0]}" in it, or another')
        return self.component or fitting[0]

    def refuse_unfit(self, component: str, described: Description) -> None:
        """Refuse names that the FMU does not have, and values that its parameters cannot have."""
        from cosim.system.compatibility import start_values
        from cosim.system.field_units import in_declared_units

        try:
            system = System((Component(component, self.fmu, self.values),))
            (given,) = in_declared_units(system, {component: described}).components
            start_values(given, described)
        except InputError as error:
            raise type(error)(f"{self.path}: {error}") from error


def load_parameters(path: Path) -> ParameterFile:
    """Read a parameter file.

    Raises
    ------
    ScenarioError
        If it cannot be read, or holds what is not understood.
    """
    content = read_toml(path)
    try:
        table = TomlTable(content, "", _KEYS)
        values, drive = (
            {key: inner.level(key) for key, _ in inner.items()} for inner in map(table.table, ("parameters", "drive"))
        )
        fmu = table.text("fmu")
        if not values:
            raise ScenarioError("expected at least one value in [parameters]")
        beside = path.resolve().parent / fmu
        return ParameterFile(
            path,
            str(beside) if Path(fmu).suffix == ".fmu" else fmu,
            values,
            drive,
            table.text("name", path.stem),
            table.text("title", path.stem),
            table.text("component", ""),
        )
    except InputError as error:
        raise type(error)(f"{path}: {error}") from error


def write_toml(content: Mapping[str, Any], comment: Iterable[str] = ()) -> str:
    """Return nested tables of numbers, Booleans, strings and lists of them as TOML, with sentences before them.

    Numbers are written to the last bit.
    """
    lines = [f"# {sentence}" for sentence in comment]
    _write_table(content, (), lines)
    return "\n".join(lines).strip() + "\n"


def _write_table(content: Mapping[str, Any], names: tuple[str, ...], lines: list[str]) -> None:
    """Write what is no table first, and then tables, each with its full name."""
    plain = {key: value for key, value in content.items() if not isinstance(value, Mapping)}
    if names and (plain or not content):
        lines += ["", f"[{'.'.join(map(_key, names))}]"]
    lines += [f"{_key(key)} = {_written(value)}" for key, value in plain.items()]
    for key, value in content.items():
        if key not in plain:
            _write_table(value, (*names, key), lines)


def _key(name: str) -> str:
    """Write a key, bare if that is possible."""
    return name if name and all(each.isascii() and (each.isalnum() or each in "_-") for each in name) else _text(name)


def _written(value: object) -> str:
    """Write a value."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_written, value))}]"  # pyright: ignore[reportUnknownArgumentType]
    return repr(value)


def _text(text: str) -> str:
    """Write a string; what JSON escapes TOML does, and DEL besides."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
