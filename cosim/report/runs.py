"""Gather what a report says of finished runs."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cosim.drilling.reporting import Findings, headings
from cosim.errors import InputError
from cosim.files import read_file, why
from cosim.fmi2.model_description import read_description
from cosim.recording.result import Result
from cosim.report.diagram import Diagram, lay_out, ways
from cosim.report.plots import number, plots_of, strokes
from cosim.report.reproduce import commands
from cosim.report.statement import count, statement
from cosim.run.opened import open_variants
from cosim.run.report import MANIFEST, CouplingReport
from cosim.system.description import Description
from cosim.system.field_units import shown_in

_MOST_BYTES = 2**30
"""Of an FMU that is looked at again."""
_LONGEST_SIGNAL = 6
"""Numbers of a signal that are shown."""


@dataclass(frozen=True)
class Parameter:
    """A parameter, with its value in each run.

    Attributes
    ----------
    component, name, unit, description : str
        What it is.
    values : tuple of str
        By run; a dash where a run has no such thing.
    differs : bool
        Whether they are not all alike.
    """

    component: str
    name: str
    unit: str
    description: str
    values: tuple[str, ...]

    @property
    def differs(self) -> bool:
        """Tell whether runs have different values."""
        return len(set(self.values)) > 1


@dataclass(frozen=True)
class SystemShown:
    """A system, and the runs that were of it.

    Attributes
    ----------
    runs : tuple of str
        Names.
    diagram : Diagram or None
        Its drawing, if it is not too large.
    connections, loops : tuple of str
        As records write them.
    """

    runs: tuple[str, ...]
    diagram: Diagram | None
    connections: tuple[str, ...]
    loops: tuple[str, ...]


def opened(folders: Sequence[Path]) -> dict[str, Result]:
    """Open runs by what tells them apart: the names of variants, and of folders where there are several.

    Raises
    ------
    InputError
        If a folder holds no finished run.
    """
    found: dict[str, Result] = {}
    for folder in dict.fromkeys(folders):
        variants = open_variants(folder)
        if not variants:
            raise InputError(f"{folder} holds a run without variants; expected one at least")
        for name, result in variants.items():
            label = name if len(folders) == 1 else f"{folder}, {name}" if len(variants) > 1 else str(folder)
            found[label] = result
    return found


def gather(folders: Sequence[Path], units: str) -> dict[str, Any]:
    """Return what the page of some finished runs shows.

    Raises
    ------
    InputError
        If a folder holds no finished run, or its record is not as it was written.
    """
    results = opened(folders)
    records = [result.record for result in results.values()]
    with _undamaged(folders):
        titles = list(dict.fromkeys(str(record["title"] or record["scenario"]) for record in records))
        known = _descriptions(results)
        plots = plots_of(results, units)
        told = [_told(name, result) for name, result in results.items()]
        lines, remarks = commands(records)
        return {
            "title": titles[0] if len(titles) == 1 else "Runs compared",
            "subtitles": titles if len(titles) > 1 else [],
            "runs": told,
            "headings": headings(),
            "energies": list(dict.fromkeys(text for each in told for text in each["energy"])),
            "switches": _switches(results),
            "plots": plots,
            "drawn": None if plots is None else plots.to_json(),
            "strokes": [] if plots is None else strokes(len(plots.runs)),
            "systems": _systems(results),
            "files": _files(results),
            "parameters": _parameters(results, known, units),
            "unknown": sorted({_key(part)[0] for part in _parts(results) if _key(part) not in known}),
            "inputs": _inputs(results),
            "commands": lines,
            "remarks": remarks,
        }


@contextmanager
def _undamaged(folders: Sequence[Path]) -> Generator[None]:
    """Say in a sentence that what manifests tell is not as it was written."""
    try:
        yield
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else why(error)
        raise InputError(f"{' or '.join(map(str, folders))}: {MANIFEST} is damaged: {what}") from error


def _told(name: str, result: Result) -> dict[str, Any]:
    """Return what is said of a run."""
    record = result.record
    findings, coupling = Findings.from_json(record), CouplingReport.from_record(record)
    verdict, why = findings.verdict()
    varies = "at most " if coupling.tolerance is not None else ""
    return {
        "name": name,
        "scenario": record["scenario"],
        "variant": record.get("variant") or "",
        "created": record["created"],
        "commit": record.get("commit") or "not known",
        "packaging": record["packaging"],
        "versions": dict(record["versions"]),
        "span": f"{coupling.start_time:g} s to {coupling.stop_time:g} s",
        "steps": f"{count(coupling.steps, 'step')} of {varies}{coupling.step_size:g} s",
        "algorithm": coupling.algorithm,
        "order": list(coupling.order),
        "verdict": verdict,
        "why": why,
        "cells": findings.cells(),
        "energy": {text: number(value) for text, value in findings.balance().items()},
        "worst": "" if not findings.energy else number(findings.energy["worst_residual"]),
        "said": [findings.sentence(), *_unsettled(coupling), *statement(coupling)],
    }


def _unsettled(coupling: CouplingReport) -> list[str]:
    """Say that values at the start went on changing, if they did."""
    start = coupling.initialisation
    return [] if start["settled"] else [f"values at the start did not settle in {count(start['rounds'], 'round')}"]


def _switches(results: Mapping[str, Result]) -> list[tuple[str, str, str, str, str]]:
    """Return of each signal that is true or false in which part of the rows it was true, and when first and last."""
    found: list[tuple[str, str, str, str, str]] = []
    for run, result in results.items():
        for name, values in result.columns.items():
            rows = np.flatnonzero(values) if values.dtype == np.bool_ else np.array([], dtype=np.intp)
            if rows.size:
                first, last = (f"{result.time[row]:.6g} s" for row in (rows[0], rows[-1]))
                found.append((run, name, f"{100.0 * rows.size / values.size:.3g} %", first, last))
    return found


def _systems(results: Mapping[str, Result]) -> list[SystemShown]:
    """Draw each system that is among the runs once."""
    alike: dict[str, list[str]] = {}
    for name, result in results.items():
        record = result.record
        models = {part: told.get("model") for part, told in record["components"].items()}
        key = json.dumps([models, record["connections"], record["loops"], sorted(record["inputs"])])
        alike.setdefault(key, []).append(name)
    return [_system(tuple(runs), results[runs[0]].record) for runs in alike.values()]


def _system(runs: tuple[str, ...], record: Mapping[str, Any]) -> SystemShown:
    """Draw a system."""
    names = list(record["components"])
    texts = {name: [str(told.get("model", ""))] for name, told in record["components"].items()}
    for port in record["inputs"]:
        owner = max((name for name in names if port.startswith(f"{name}.")), key=len, default=None)
        if owner is not None:
            texts[owner].append(f"given: {port[len(owner) + 1 :]}")
    connections, loops = tuple(record["connections"]), tuple(record["loops"])
    return SystemShown(runs, lay_out(texts, ways(names, connections, loops)), connections, loops)


def _parts(results: Mapping[str, Result]) -> list[Mapping[str, Any]]:
    """Return what is told of all components of all runs."""
    return [part for result in results.values() for part in result.record["components"].values()]


def _key(part: Mapping[str, Any]) -> tuple[str, str]:
    """Return which file a component is."""
    return str(part.get("file", part.get("model", ""))), str(part.get("sha256", ""))


def _files(results: Mapping[str, Result]) -> list[tuple[str, str, str]]:
    """Return model, name of the file and hash of each FMU that ran; where it lay is nobody else's matter."""
    told = [(str(part.get("model", "")), *_key(part)) for part in _parts(results)]
    return list(dict.fromkeys((model, Path(file).name, digest) for model, file, digest in told))


def _descriptions(results: Mapping[str, Result]) -> dict[tuple[str, str], Description]:
    """Read the FMUs that are where they were and what they were; they tell units, which records do not."""
    found: dict[tuple[str, str], Description] = {}
    for part in _parts(results):
        path, digest = _key(part)
        if (path, digest) in found or not path.endswith(".fmu"):
            continue
        try:
            if hashlib.sha256(read_file(Path(path), _MOST_BYTES)).hexdigest() == digest:
                found[path, digest] = read_description(Path(path))
        except (OSError, InputError):
            continue
    return found


def _parameters(
    results: Mapping[str, Result], known: Mapping[tuple[str, str], Description], units: str
) -> list[Parameter]:
    """Return all parameters of all runs."""
    names: dict[tuple[str, str], None] = {}
    for result in results.values():
        for component, told in result.record["components"].items():
            names |= dict.fromkeys((component, name) for name in told["parameters"])
    return [_parameter(results, known, units, *name) for name in names]


def _parameter(
    results: Mapping[str, Result], known: Mapping[tuple[str, str], Description], units: str, component: str, name: str
) -> Parameter:
    """Return a parameter with its values."""
    parts = [result.record["components"].get(component) for result in results.values()]
    described = [known[_key(part)].by_name.get(name) for part in parts if part and _key(part) in known]
    variable = next((each for each in described if each is not None), None)
    unit = variable.unit.name if variable is not None and variable.unit is not None else ""
    shown, factor = shown_in(unit, units) if units != "si" else (unit, 1.0)
    values = [_value(part, name, factor) for part in parts]
    return Parameter(component, name, shown, variable.description if variable else "", tuple(values))


def _value(part: Mapping[str, Any] | None, name: str, factor: float) -> str:
    """Write a value; in full, since a run is made again by it."""
    if part is None or name not in part["parameters"]:
        return "-"
    told = _number(part["parameters"][name], factor)
    asked = part.get("asked", {})
    return f"{told} (set to {_number(asked[name], factor)}, not kept)" if name in asked else told


def _number(value: Any, factor: float) -> str:
    """Write one value."""
    if isinstance(value, float):
        return f"{value * factor:.12g}"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _inputs(results: Mapping[str, Result]) -> list[tuple[str, str, tuple[str, ...]]]:
    """Return what drives inputs from outside, by run, with the unit."""
    ports = dict.fromkeys(port for result in results.values() for port in result.record["inputs"])
    return [
        (
            port,
            next((result.units[port] for result in results.values() if port in result.units), ""),
            tuple(_signal(result.record["inputs"].get(port)) for result in results.values()),
        )
        for port in ports
    ]


def _signal(told: Mapping[str, Any] | None) -> str:
    """Write a signal: the value of a constant, else its kind and its numbers."""
    if told is None:
        return "-"
    if told.get("kind") == "constant":
        return _short(told.get("value"))
    numbers = ", ".join(f"{name} {_short(value)}" for name, value in told.items() if name != "kind")
    return f"{told.get('kind', '')} ({numbers})"


def _short(value: object) -> str:
    """Write a value, or the first of many."""
    if isinstance(value, list | tuple):
        cells = [_short(each) for each in value[:_LONGEST_SIGNAL]]  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
        return ", ".join(cells) + (" …" if len(value) > _LONGEST_SIGNAL else "")  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(value, float):
        return f"{value:.12g}"
    return str(value).lower() if isinstance(value, bool) else str(value)
