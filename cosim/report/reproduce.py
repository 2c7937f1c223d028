"""Say by which commands runs are made again."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping
from typing import Any

from cosim.errors import InputError
from cosim.run.assembly import described
from cosim.run.options import RunOptions
from cosim.scenario.file import load_scenario, scenario_names
from cosim.system.description import Variable

_OPTIONS = ("algorithm", "step_size", "stop_time", "tolerance", "on_failure")


def commands(records: Iterable[Mapping[str, Any]]) -> tuple[list[str], list[str]]:
    """Return commands that make runs again, and what has to be said of them.

    Parameters
    ----------
    records : iterable of mapping
        What is recorded of each run.

    Returns
    -------
    list of str, list of str
        Commands, of which one makes all variants that were run alike; and sentences.
    """
    alike: dict[tuple[str, str], list[str]] = {}
    remarks: list[str] = []
    for record in records:
        values, remark = _values(record)
        key = f"cosim run {shlex.quote(str(record['scenario']))}", " ".join([*_options(record), *values])
        alike.setdefault(key, []).extend(_variant(record))
        remarks += remark
    lines = [" ".join([begin, *variants, options]).strip() for (begin, options), variants in alike.items()]
    return lines, list(dict.fromkeys(remarks))


def _variant(record: Mapping[str, Any]) -> list[str]:
    """Return the option that chooses the variant, if there are any."""
    return ["--variant " + shlex.quote(str(record["variant"]))] if record.get("variant") else []


def _options(record: Mapping[str, Any]) -> list[str]:
    """Return the options of a run."""
    told = {**record.get("method", {}), **record}
    given = {name: told.get(name) for name in _OPTIONS}
    if not record.get("loops") or given["algorithm"] != "implicit":
        given["on_failure"] = None
    words = [f"--packaging {shlex.quote(str(record['packaging']))}"]
    for name, value in given.items():
        if value is not None:
            words.append(f"--{name.replace('_', '-')} {shlex.quote(_written(value))}")
    return [*words, "--isolate"] if record.get("isolated") else words


def _values(record: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """Return the values that differ from the scenario's own, to be set, and what is not known of them."""
    name = str(record["scenario"])
    if name not in scenario_names():
        said = f"'{name}' stands for the scenario's file, whose values have to be those in the tables above"
        return [], [said]
    try:
        own, inputs = _own_values(record)
    except (InputError, KeyError, TypeError, ValueError):
        return [], [f"what differs from the values of scenario '{name}' itself is not known: set what the tables say"]
    given = {
        f"{part}.{variable}": value
        for part, told in record["components"].items()
        for variable, value in {**told["parameters"], **told.get("asked", {})}.items()
    }
    changed = {name: value for name, value in given.items() if name in own and own[name] != _written(value)}
    remarks: list[str] = []
    for port, signal in record["inputs"].items():
        if inputs.get(port) == _plain(signal):
            continue
        if signal.get("kind") == "constant":
            changed[port] = signal["value"]
        else:
            remarks.append(f"{port} is driven otherwise than scenario '{name}' does: by the signal in the table above")
    return [f"--set {shlex.quote(f'{port}={_written(value)}')}" for port, value in changed.items()], remarks


def _own_values(record: Mapping[str, Any]) -> tuple[dict[str, str], dict[str, Any]]:
    """Return the values that the scenario sets or leaves as they start, and its inputs."""
    scenario = load_scenario(str(record["scenario"]))
    options = RunOptions(packaging=str(record["packaging"]), variant=record.get("variant"))
    system, descriptions, _ = described(scenario, options)
    own: dict[str, str] = {}
    for part in system.components:
        for variable in descriptions[part.name].variables:  # inputs too, which a scenario may set as parameters
            value = part.parameters.get(variable.name, variable.start)
            own[f"{part.name}.{variable.name}"] = _written(_read(value, variable))
    return own, {str(port): _plain(signal.record()) for port, signal in system.inputs.items()}


def _read(value: Any, variable: Variable) -> Any:
    """Read a start value as records tell it."""
    if not isinstance(value, str):
        return value
    if variable.type == "Real":
        return float(value)
    if variable.type == "Boolean":
        return value in ("true", "1")
    if variable.items:
        return next((item for item, number in variable.items.items() if str(number) == value), value)
    return int(value) if variable.type == "Integer" else value


def _plain(signal: Mapping[str, Any]) -> dict[str, Any]:
    """Return a signal with lists as JSON has them."""
    return {name: list(value) if isinstance(value, tuple) else value for name, value in signal.items()}  # pyright: ignore[reportUnknownArgumentType]


def _written(value: Any) -> str:
    """Write a value so that it is read back the same."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)
