"""Make of a scenario what workers need to run its points.

What is wrong with a sweep is told here, before anything is run.
"""

from __future__ import annotations

import hashlib
import json
import math
import pickle
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, cast

from cosim.errors import InputError, SystemDefinitionError, format_time
from cosim.fmi2.locate import locate_fmu
from cosim.provenance import commit, versions
from cosim.run.assembly import described, record_components
from cosim.run.function import functions_of
from cosim.run.options import RunOptions
from cosim.scenario.scenario import Scenario
from cosim.sweeps.design import Axis, Design
from cosim.sweeps.measures import Beginning, MeasureSet, Quantity
from cosim.sweeps.point_plan import File, PointPlan
from cosim.sweeps.reading import HELD, SAMPLING, SERIES
from cosim.sweeps.series import Kept, Wanted, kept_of
from cosim.system.compatibility import Written, check_system, convert, read_value
from cosim.system.description import Description, Variable
from cosim.system.field_units import in_declared_unit
from cosim.system.signals import Constant, Value
from cosim.system.structure import Port, System

FORMAT = 1
"""Of stores: what has another number is not gone on with."""


@dataclass(frozen=True)
class Sweep:
    """A sweep that is ready to be run.

    Attributes
    ----------
    plan : PointPlan
        What workers need.
    design : Design
        The points.
    units : mapping of str to str
        By name of what varies.
    texts : mapping of str to str
        What it is.
    record : mapping of str to value
        All that decides the results, by what it is; see `differing`.
    told : mapping of str to value
        What is recorded besides.
    beginning : Beginning or None
        What else is set at the first point of a line.
    kept : Kept or None
        What is kept over time, and of which points.
    """

    plan: PointPlan
    design: Design
    units: Mapping[str, str]
    texts: Mapping[str, str]
    record: Mapping[str, Any]
    told: Mapping[str, Any]
    beginning: Beginning | None = None
    kept: Kept | None = None

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Return what is kept of each point."""
        return self.plan.measures.quantities

    @property
    def digest(self) -> str:
        """Return the SHA-256 of all that decides the results."""
        return hashlib.sha256(json.dumps(self.record, sort_keys=True).encode()).hexdigest()

    def first_values(self, line: int) -> Mapping[str, Value]:
        """Return what else is set at the first point of a line."""
        return self.beginning(self.design.values(line, 0)) if self.beginning is not None else {}

    def kept_steps(self, line: int) -> tuple[int, ...]:
        """Return at which points of a line signals are kept over time."""
        kept = self.kept
        if kept is None:
            return ()
        steps = range(self.design.length)
        return tuple(step for step in steps if kept.place(self.design.place(line, step)) is not None)


@dataclass(frozen=True)
class Opened:
    """A scenario with its FMUs, read and not run.

    Attributes
    ----------
    scenario : Scenario
        What it is of.
    options : RunOptions
        How to run it.
    system : System
        With the values of variant and options.
    paths : mapping of str to Path
        Files of the components.
    descriptions : mapping of str to Description
        Of the components.
    """

    scenario: Scenario
    options: RunOptions
    system: System
    paths: Mapping[str, Path]
    descriptions: Mapping[str, Description]

    def variable(self, name: str) -> Variable | None:
        """Return what is varied by a name; None where that is a whole component.

        Raises
        ------
        SystemDefinitionError
            If it does not exist, or cannot be set.
        """
        if "." not in name:
            if name not in self.descriptions:
                self.system.component_of(f"{name}.{name}")
            if name not in self.paths:
                raise SystemDefinitionError(f"{name} is a Python function; expected an FMU whose place others take")
            return None
        port = Port.parse(name)
        part = self.system.component_of(port)
        known = self.descriptions[part.name]
        if port.variable not in known.by_name:
            from cosim.system.compatibility import start_values  # which knows the sentence

            start_values(replace(part, parameters={port.variable: 0.0}), known)
        driver = next((each.source for each in self.system.connections if each.target == port), None)
        if driver is not None:
            raise SystemDefinitionError(f"{name} is driven by {driver}; expected what nothing drives")
        return known.by_name[port.variable]

    def typed(self, name: str, values: Sequence[Value]) -> list[Value]:
        """Return values of what is varied by a name, read and checked by its type."""
        variable = self.variable(name)
        if variable is None:
            return [str(value) for value in values]
        read = [read_value(value, variable) if isinstance(value, Written) else value for value in values]
        read = [in_declared_unit(name, variable, value) for value in read]
        if variable.type == "Integer":
            read = [int(value) if isinstance(value, float) and value.is_integer() else value for value in read]
        if variable.type == "Real":
            read = [float(value) if type(value) is int else value for value in read]
        for value in read:
            convert(name, variable, value)
        return read


def open_system(scenario: Scenario, options: RunOptions) -> Opened:
    """Read what a scenario consists of.

    Raises
    ------
    InputError
        If something does not exist, or is a Python function that cannot go to workers.
    """
    system, descriptions, paths = described(scenario, options)
    for name, callee in functions_of(system).items():
        try:
            pickle.dumps(callee.function)
        except Exception as error:  # whatever an object raises that is not to be sent
            raise SystemDefinitionError(
                f"{name}: the Python function {callee.name} cannot be sent to workers ({error}); expected one that is "
                "defined at the top of a module"
            ) from error
    return Opened(scenario, options, system, paths, descriptions)


def make_sweep(
    opened: Opened, design: Design, measures: MeasureSet, beginning: Beginning | None, keep: Wanted | None = None
) -> Sweep:
    """Check a sweep as a whole, and make what workers need.

    Raises
    ------
    InputError
        If anything does not fit.
    """
    varied = [name for axis in design.axes for name in axis.values]
    variables = {name: opened.variable(name) for name in varied}
    _refuse_fixed(design, variables)
    files: dict[str, File] = {}
    choices: dict[str, dict[str, str]] = {}
    functions = functions_of(opened.system)
    for part in opened.system.components:
        if part.name in functions:
            continue
        values = next((axis.values[part.name] for axis in design.axes if part.name in axis.values), None)
        wanted = {str(part.fmu): opened.paths[part.name]} if values is None else _alternatives(opened, values)
        choices[part.name] = {name: _add(files, path) for name, path in wanted.items()}
    plan = PointPlan(
        system=_driven(opened, variables, design),
        files=files,
        choices=choices,
        chosen={
            part.name: str(part.fmu)
            for part in opened.system.components
            if part.name not in varied and part.name not in functions
        },
        names=tuple(varied),
        start_time=opened.scenario.start_time,
        duration=_duration(opened),
        step_size=_step_size(opened),
        points_per_run=design.length,
        method=opened.options.method(opened.scenario),
        measures=measures,
        functions={name: opened.descriptions[name] for name in functions},
    )
    _check(plan, design)
    kept = None if keep is None else _kept(plan, design, keep)
    plan = plan if kept is None else replace(plan, series=kept.rows)
    record, told = _record(opened, plan, design, beginning)
    if kept is not None:
        record[SERIES] = told[SERIES] = kept.record(design)
    shown = {name: variable for name, variable in variables.items() if variable is not None}
    units = {name: variable.unit.name if variable.unit else "" for name, variable in shown.items()}
    texts = {name: variable.description for name, variable in shown.items()}
    return Sweep(plan, design, units, texts, record, told, beginning, kept)


def _kept(plan: PointPlan, design: Design, wanted: Wanted) -> Kept:
    """Say what is kept over time, and of which points."""
    if plan.method.tolerance is not None:
        raise InputError("the steps vary with the tolerance; series are kept of runs with steps of one size only")
    step_size = None if plan.takes_long_steps else plan.step_size
    return kept_of(wanted, design, plan.known_descriptions(), (plan.start_time, plan.duration), step_size)


def _duration(opened: Opened) -> float:
    """Return how long a point is run, s."""
    given, start = opened.options.stop_time, opened.scenario.start_time
    stop = opened.scenario.stop_time if given is None else given
    if not (math.isfinite(stop) and stop > start):
        raise InputError(f"stop time is {stop:g} s; expected a time after the start, {format_time(start)} s")
    return stop - start


def _step_size(opened: Opened) -> float:
    """Return how long a step of the scenario is, s; long steps are checked as well, which do not take it."""
    given = opened.options.step_size
    step_size = opened.scenario.step_size if given is None else given
    if not (math.isfinite(step_size) and step_size > 0.0):
        raise InputError(f"step size is {step_size:g} s; expected a number > 0")
    return step_size


def _refuse_fixed(design: Design, variables: Mapping[str, Variable | None]) -> None:
    """Refuse to continue runs along what a run cannot change."""
    if design.along is not None:
        variable = variables[design.along]
        if variable is None or variable.causality != "input":
            kind = "a component" if variable is None else f"a {variable.causality}"
            raise InputError(f"{design.along} is {kind}; runs are continued along an input only")


def _alternatives(opened: Opened, values: Sequence[Value]) -> dict[str, Path]:
    """Find the files of the FMUs that take the place of a component."""
    packaging, folder = opened.options.packaging, opened.scenario.folder
    return {str(value): locate_fmu(str(value), packaging, folder) for value in values}


def _add(files: dict[str, File], path: Path) -> str:
    """Read an FMU, and return its SHA-256."""
    from cosim.fmi2.model_description import read_description

    content = path.read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    if digest not in files:
        files[digest] = File(path.name, content, read_description(path))
    return digest


def _driven(opened: Opened, variables: Mapping[str, Variable | None], design: Design) -> System:
    """Return the system in which inputs that vary are driven by constants, so that a run can go on with another."""
    system = opened.system
    first = design.values(0, 0)
    inputs = {name: first[name] for name, each in variables.items() if each is not None and each.causality == "input"}
    parts = tuple(
        replace(
            part,
            parameters={n: value for n, value in part.parameters.items() if f"{part.name}.{n}" not in inputs},
        )
        for part in system.components
    )
    driven = {Port.parse(name): Constant(value) for name, value in inputs.items()}
    return replace(system, components=parts, inputs={**system.inputs, **driven})


def _check(plan: PointPlan, design: Design) -> None:
    """Hold the system against the FMUs, for each choice of them, and columns against what they put out."""
    values = design.values(0, 0)
    axes = [axis for axis in design.axes if any(name in plan.choices for name in axis.values)]
    for each in _combinations(plan, axes):
        chosen, rest = plan.split({**values, **each})
        descriptions = plan.descriptions(chosen)
        check_system(plan.system_of(chosen).with_values(rest), descriptions)
        for name in plan.measures.columns:
            port = Port.parse(name)
            output = descriptions[port.component].by_name.get(port.variable)
            if output is None or output.causality != "output":
                raise SystemDefinitionError(
                    f"{name} is to be measured, and {descriptions[port.component].model_name} has no such output"
                )
        if design.along is not None:
            _refuse_stateless(descriptions)
    if plan.measures.window > plan.duration:
        raise InputError(
            f"points are run for {plan.duration:g} s; expected {plan.measures.window:g} s, which are measured, or more"
        )


def _combinations(plan: PointPlan, axes: Collection[Axis]) -> Iterator[dict[str, Value]]:
    """Go through the choices of FMUs."""
    names = [name for axis in axes for name in axis.values if name in plan.choices]
    for values in product(*(plan.choices[name] for name in names)):
        yield dict(zip(names, values, strict=True))


def _refuse_stateless(descriptions: Mapping[str, Description]) -> None:
    """Refuse to continue runs of FMUs whose states cannot be kept."""
    for name, description in descriptions.items():
        if not description.can_serialize_state:
            raise InputError(
                f"{name}: {description.model_name} cannot serialise its state (canSerializeFMUstate), so that its runs "
                "cannot be continued; expected the branch rest"
            )


def _record(
    opened: Opened, plan: PointPlan, design: Design, beginning: Beginning | None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Write down what decides the results, and what else is to be known of them."""
    components = record_components(opened.system, opened.paths, opened.descriptions)
    for known in components.values():
        del known["file"]
    known_versions = versions()
    record: dict[str, Any] = {
        "format": FORMAT,
        "product": known_versions["drillstring-cosim"],
        "axes": {axis.name: {name: _digest(values) for name, values in axis.values.items()} for axis in design.axes},
        "branch": "rest" if design.along is None else "down" if design.down else "up",
        "scenario": opened.scenario.name,
        "components": components,
        "fmus": {name: dict(files) for name, files in plan.choices.items()},
        "connections": [_connection(each) for each in plan.system.connections],
        "inputs": {name: s.record() for name, s in plan.system.inputs.items() if name not in plan.names},
        "start_time": plan.start_time,
        "duration": plan.duration,
        "step_size": plan.step_size,
        "method": vars(plan.method),
        "along": design.along or "",
        "beginning": beginning.identity if beginning is not None else "",
        "measures": [plan.measures.identity, plan.measures.window, [each.name for each in plan.measures.quantities]],
    }
    told = {
        "title": opened.scenario.title,
        "variant": opened.options.variant or "",
        "packaging": opened.options.packaging,
        "commit": commit() or "",
        "versions": known_versions,
        "steps": "long" if plan.takes_long_steps else "scenario",
        HELD: _held(opened, plan),
    }
    drawn = next((axis.drawn for axis in design.axes if axis.drawn), None)
    if drawn is not None:
        told[SAMPLING] = dict(drawn)
    return cast(dict[str, Any], json.loads(json.dumps(record))), told


def _held(opened: Opened, plan: PointPlan) -> dict[str, Value]:
    """Return the values of inputs that are the same at all points, all the time."""
    found: dict[str, Value] = {}
    for part in plan.system.components:
        for each in opened.descriptions[part.name].with_causality("input"):
            value = part.parameters.get(each.name, each.start_value)
            if value is not None:
                found[f"{part.name}.{each.name}"] = value
    for port, signal in plan.system.inputs.items():
        found.pop(str(port), None)
        if isinstance(signal, Constant):
            found[str(port)] = signal.value
    driven = {str(each.target) for each in plan.system.connections} | set(plan.names)
    return {name: value for name, value in found.items() if name not in driven}


def _connection(connection: Any) -> str:
    """Write a connection with what becomes of the value."""
    how = [connection.factor, connection.offset, connection.unconverted, connection.table]
    return f"{connection.source} -> {connection.target} {json.dumps(how)}"


def _digest(values: Sequence[Value]) -> str:
    """Return the SHA-256 of values."""
    return hashlib.sha256(json.dumps(list(values)).encode()).hexdigest()
