"""Input signals as they are written in a scenario file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import cast

from cosim.errors import ScenarioError, suggestion
from cosim.scenario.toml_table import TomlTable
from cosim.system.signals import Constant, Signal, Step, ramp, read_table, table_of_points

_SIGNAL_KEYS = {
    "step": ("before", "after", "at"),
    "ramp": ("initial", "final", "start", "duration"),
    "table": ("points", "file", "column"),
}


def read_signal(content: object, where: str, folder: Path) -> Signal:
    """Build a signal from a number, a Boolean, or a table with a kind.

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
    if isinstance(content, bool | int | float):
        return Constant(content)
    if not isinstance(content, dict):
        raise ScenarioError(f"{where} is {content!r}; expected a number, true, false or a table with a kind")
    kind = TomlTable(cast(object, content), where).text("kind")
    if kind not in _SIGNAL_KEYS:
        raise ScenarioError(f"{where}.kind is '{kind}'{suggestion(kind, _SIGNAL_KEYS)}")
    table = TomlTable(cast(object, content), where, ("kind", *_SIGNAL_KEYS[kind]))
    build: dict[str, Callable[[], Signal]] = {
        "step": lambda: Step(table.number_or_boolean("before"), table.number_or_boolean("after"), table.number("at")),
        "ramp": lambda: ramp(*(table.number(key) for key in _SIGNAL_KEYS["ramp"])),
        "table": lambda: _points(table, folder),
    }
    try:
        return build[kind]()
    except ScenarioError as error:
        message = str(error)
        raise ScenarioError(message if where in message else f"{where}: {message}") from None


def _points(table: TomlTable, folder: Path) -> Signal:
    """Build a table from points in place or from a CSV file beside the scenario."""
    if ("points" in table) == ("file" in table):
        raise ScenarioError("expected either points or file")
    if "file" in table:
        return read_table(folder / table.text("file"), table.text("column", "") or None)
    points: list[list[float]] = []
    for point in table.array("points"):
        if not isinstance(point, list) or not all(isinstance(x, int | float) for x in cast(list[object], point)):
            raise ScenarioError(f"points hold {point!r}; expected pairs of numbers, time and value")
        points.append(cast(list[float], point))
    return table_of_points(points)
