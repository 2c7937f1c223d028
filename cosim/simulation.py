"""From a scenario to a result: find the FMUs, check, open, run, close, and say how it was done."""

from __future__ import annotations

import hashlib
import platform
import time
from collections.abc import Collection, Mapping
from contextlib import ExitStack
from dataclasses import fields, is_dataclass, replace
from importlib import metadata
from pathlib import Path
from typing import Any

import fmpy  # pyright: ignore[reportMissingTypeStubs]
import numpy as np

from cosim.description import Description, Variable, read_description
from cosim.errors import SystemDefinitionError, suggestion
from cosim.fmu_slave import open_fmu
from cosim.isolated_process import Limits
from cosim.isolated_slave import open_isolated_fmu
from cosim.locate import locate_fmu
from cosim.master import co_simulate
from cosim.result import Result
from cosim.run import Progress
from cosim.scenario import Scenario
from cosim.signals import Signal, Value
from cosim.slave import Slave
from cosim.system import System


def simulate(
    scenario: Scenario,
    *,
    packaging: str = "native",
    algorithm: str | None = None,
    tolerance: float | None = None,
    on_failure: str | None = None,
    step_size: float | None = None,
    stop_time: float | None = None,
    overrides: Mapping[str, Value] | None = None,
    variant: str | None = None,
    progress: Progress | None = None,
    isolate: bool | Collection[str] = False,
    limits: Limits | None = None,
) -> Result:
    """Run one variant of a scenario.

    Parameters
    ----------
    scenario : Scenario
        From `cosim.load_scenario`, or made in Python.
    packaging : str
        ``"native"`` or ``"python"``: which build of the FMUs that are given by name.
    algorithm : str, optional
        ``"jacobi"``, ``"gauss-seidel"`` or ``"implicit"`` instead of the scenario's.
    tolerance : float, optional
        Of the error of a step, instead of the scenario's; the step size varies then, and `step_size` is the greatest.
    on_failure : str, optional
        ``"fail"``, ``"halve"`` or ``"explicit"``, where a loop has no solution, instead of the scenario's.
    step_size, stop_time : float, optional
        In s, instead of the scenario's.
    overrides : mapping of str to value, optional
        Parameters and input values by ``component.variable``, on top of the variant's.
    variant : str, optional
        Name of the variant; by default the first.
    progress : callable, optional
        Called now and then with the part of the run that is done, from 0 to 1.
    isolate : bool or collection of str
        Run all components, or those of these names, in processes of their own, as well as those that the scenario
        isolates. A crash there is a `LostSlaveError` here.
    limits : Limits, optional
        Of time and memory, for the isolated components.

    Returns
    -------
    Result
        Every input and output of every component: ``result["plant.bit_speed"]`` over ``result.time``.

    Raises
    ------
    InputError
        If something asked for does not exist or does not fit; no component has been initialised then.
    RunError
        If a component fails on the way.
    """
    chosen = scenario.variant(variant)
    settings = {"algorithm": algorithm, "tolerance": tolerance, "on_failure": on_failure}
    method = replace(scenario.method, **{name: value for name, value in settings.items() if value is not None})
    system = scenario.system_of(chosen, overrides)
    paths = {part.name: locate_fmu(part.fmu, packaging, scenario.folder) for part in system.components}
    descriptions = {name: read_description(path) for name, path in paths.items()}
    isolated = _isolated(system, isolate)
    _refuse_twins(paths, {name: known for name, known in descriptions.items() if name not in isolated})
    began = time.perf_counter()
    with ExitStack() as stack:
        slaves: dict[str, Slave] = {}
        for name, path in paths.items():
            if name in isolated:
                slaves[name] = stack.enter_context(open_isolated_fmu(name, path, descriptions[name], limits))
            else:
                slaves[name] = stack.enter_context(open_fmu(name, path, descriptions[name]))
        loaded = time.perf_counter() - began
        result = co_simulate(
            system,
            slaves,
            stop_time=scenario.stop_time if stop_time is None else stop_time,
            step_size=scenario.step_size if step_size is None else step_size,
            start_time=scenario.start_time,
            method=method,
            progress=progress,
        )
    record: dict[str, Any] = {"scenario": scenario.name, "variant": chosen.name if chosen else None}
    record |= {"packaging": packaging, **result.record}
    record["timings"] = {"load": loaded, **result.record["timings"]}
    record["components"] = _components(system, paths, descriptions)
    record["isolated"] = sorted(isolated)
    record["inputs"] = {name: _signal(signal) for name, signal in system.inputs.items()}
    record["versions"] = versions()
    return Result(result.time, result.columns, result.units, record)


def versions() -> dict[str, str]:
    """Return the versions of what computes, and the platform."""
    return {
        "drillstring-cosim": metadata.version("drillstring-cosim"),
        "fmpy": fmpy.__version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
        "platform": fmpy.platform_tuple,
    }


def _isolated(system: System, isolate: bool | Collection[str]) -> frozenset[str]:
    """Return the names of the components to be isolated."""
    names = [part.name for part in system.components]
    wanted = (
        names if isolate is True else [] if isolate is False else [isolate] if isinstance(isolate, str) else isolate
    )
    for name in wanted:
        if name not in names:
            raise SystemDefinitionError(f"there is no component '{name}' to isolate{suggestion(name, names)}")
    return frozenset(wanted) | {part.name for part in system.components if part.isolate}


def _refuse_twins(paths: Mapping[str, Path], descriptions: Mapping[str, Description]) -> None:
    """Refuse two instances of an FMU that a process can hold only once."""
    seen: dict[str, str] = {}
    for name, description in descriptions.items():
        if not description.once_per_process:
            continue
        if description.guid in seen:
            raise SystemDefinitionError(
                f"{seen[description.guid]} and {name} are both {paths[name].name}, which allows one instance only"
            )
        seen[description.guid] = name


def _components(
    system: System, paths: Mapping[str, Path], descriptions: Mapping[str, Description]
) -> dict[str, dict[str, Any]]:
    """Say which file each component is, and every parameter it ran with, given or by default."""
    components: dict[str, dict[str, Any]] = {}
    for part in system.components:
        description = descriptions[part.name]
        parameters = {variable.name: _start(variable) for variable in description.with_causality("parameter")}
        components[part.name] = {
            "model": description.model_name,
            "file": str(paths[part.name]),
            "sha256": hashlib.sha256(paths[part.name].read_bytes()).hexdigest(),
            "parameters": {**parameters, **part.parameters},
        }
    return components


def _start(variable: Variable) -> Value | None:
    """Read a start value of a model description as what it stands for."""
    text = variable.start
    if text is None or variable.type == "String":
        return text
    if variable.type == "Boolean":
        return text in ("true", "1")
    if variable.type == "Enumeration":
        return next((name for name, number in variable.items.items() if number == int(text)), int(text))
    return float(text) if variable.type == "Real" else int(text)


def _signal(signal: Signal) -> dict[str, Any]:
    """Write a signal as its kind and the numbers it is made from."""
    parts = fields(signal) if is_dataclass(signal) else ()
    made_from = {part.name: getattr(signal, part.name) for part in parts if part.init}
    return {"kind": type(signal).__name__.lower(), **made_from}
