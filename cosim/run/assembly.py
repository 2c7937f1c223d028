"""Make a master that is ready to run from a scenario: find the FMUs, check, open, and say what they are."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cosim.errors import Refusals, ScenarioError, SystemDefinitionError, format_time, suggestion
from cosim.files import digest_of
from cosim.fmi2.isolation import Limits
from cosim.fmi2.locate import locate_fmu
from cosim.master.co_simulation import Master
from cosim.master.slave import Slave
from cosim.provenance import versions
from cosim.run.function import FunctionSlave, describe_functions, functions_of, with_functions
from cosim.run.options import RunOptions
from cosim.run.report import CouplingReport, RunReport
from cosim.scenario.scenario import Scenario, Variant
from cosim.system.compatibility import check_signals, check_system, read_written, start_values
from cosim.system.description import Description, Variable
from cosim.system.field_units import in_declared_units
from cosim.system.signals import Value
from cosim.system.structure import Port, System

log = logging.getLogger("cosim")

_MOST_FLAWS = 3


@dataclass(frozen=True)
class Assembly:
    """A master with its components, loaded and not yet initialised.

    Attributes
    ----------
    master : Master
        Ready to begin.
    descriptions : mapping of str to Description
        Of the components.
    provenance : mapping
        What is run: scenario, variant, components with their files and parameters, inputs, versions.
    loading : float
        How long it took, s.
    slaves : mapping of str to Slave
        The components.
    undisturbed : callable
        Returns a context for a run in which nothing but FMUs can change this process.
    """

    master: Master
    descriptions: Mapping[str, Description]
    provenance: Mapping[str, Any]
    loading: float
    slaves: Mapping[str, Slave]
    undisturbed: Callable[[], AbstractContextManager[None]] = nullcontext

    def report(self, account: Mapping[str, Any]) -> RunReport:
        """Return how a run was made, by what the master tells of it."""
        told: dict[str, Any] = {**account, "timings": {"load": self.loading, **account["timings"]}}
        return RunReport(**self.initialised(), coupling=CouplingReport(**told))

    def initialised(self) -> dict[str, Any]:
        """Return what is run, with the parameters that FMUs have after initialisation, and what they were asked for."""
        components: dict[str, dict[str, Any]] = {}
        for name, known in self.provenance["components"].items():
            not_kept: Mapping[str, Value] = getattr(self.slaves[name], "not_kept", {})
            by_name = self.descriptions[name].by_name
            has = {each: _item(by_name[each], value) for each, value in not_kept.items()}
            asked = {each: value for each, value in known["parameters"].items() if each in has}
            changed = {"parameters": {**known["parameters"], **has}, "asked": asked}
            components[name] = {**known, **changed} if has else known
        return {**self.provenance, "components": components}


@contextmanager
def assembled(scenario: Scenario, options: RunOptions) -> Generator[Assembly]:
    """Load the components of a scenario, and free them afterwards, whatever happens.

    Raises
    ------
    InputError
        If something asked for does not exist or does not fit; no component has been initialised then.
    RunError
        If a component cannot be instantiated.
    """
    variant = scenario.variant(options.variant)
    method = options.method(scenario)
    system, descriptions, paths = described(scenario, options)
    _tell_flaws(paths, descriptions)
    isolated = modules_apart(paths, _isolated(system, options.isolate))
    _refuse_twins(paths, {name: descriptions[name] for name in paths if name not in isolated})
    began = time.perf_counter()
    with ExitStack() as stack:
        slaves: dict[str, Slave] = {}
        repeats = method.implicit or method.tolerance is not None
        for name, callee in functions_of(system).items():
            slaves[name] = FunctionSlave(name, callee, descriptions[name], repeats=repeats)
        for name, path in paths.items():
            limits = (options.limits or Limits()) if name in isolated else None
            with _refused_with_others(system, paths, descriptions):
                slaves[name] = stack.enter_context(_opened(name, path, descriptions[name], limits))
        slaves = {name: slaves[name] for name in descriptions}
        loading = time.perf_counter() - began
        turn, undisturbed = _turns([name for name in paths if name not in isolated])
        master = Master(
            system,
            slaves,
            stop_time=scenario.stop_time if options.stop_time is None else options.stop_time,
            step_size=scenario.step_size if options.step_size is None else options.step_size,
            start_time=scenario.start_time,
            method=method,
            turn=turn,
        )
        signals = [name for name in scenario.signals if Port.parse(name).component not in (options.components or {})]
        _refuse_unrecorded(scenario, signals, [column.name for column in master.columns])
        provenance = {
            "scenario": scenario.name,
            "variant": variant.name if variant else None,
            "packaging": options.packaging,
            "components": record_components(system, paths, descriptions),
            "isolated": sorted(isolated),
            "inputs": {name: signal.record() for name, signal in system.inputs.items()},
            "versions": versions(),
        }
        yield Assembly(master, descriptions, provenance, loading, slaves, undisturbed)


def described(scenario: Scenario, options: RunOptions) -> tuple[System, dict[str, Description], dict[str, Path]]:
    """Return the system that is run, its values read, with descriptions by component, and files of those that are FMUs.

    Raises
    ------
    InputError
        If a component does not exist, or a value is in a unit that does not fit.
    """
    from cosim.fmi2.model_description import read_description  # with fmpy, which importing this module does without

    system = _system(scenario, scenario.variant(options.variant), options)
    paths = _paths(system, options.packaging, scenario.folder)
    found = {name: read_description(path) for name, path in paths.items()}
    found |= describe_functions(system, found)
    descriptions = {part.name: found[part.name] for part in system.components}
    return in_declared_units(read_written(system, descriptions), descriptions), descriptions, paths


def refuse_unfit_variants(scenario: Scenario, labels: Sequence[str], packaging: str) -> None:
    """Refuse values of variants that do not fit, those of the last as well, before the first is run."""
    from cosim.fmi2.model_description import read_description  # with fmpy, which importing this module does without

    known: dict[Path, Description] = {}
    refusals = Refusals()
    for variant in (each for each in scenario.variants if each.name in labels):
        system = scenario.system_of(variant)
        for part in (part for part in system.components if not callable(part.fmu)):
            given = {name: value for name, value in part.parameters.items() if f"{part.name}.{name}" in variant.values}
            path = locate_fmu(part.fmu, packaging, scenario.folder)
            if path not in known:
                known[path] = read_description(path)
            start_values(replace(part, parameters=given), known[path])
            inputs = {
                port: signal
                for port, signal in system.inputs.items()
                if port.component == part.name and port in variant.values
            }
            alone, described_alone = System((replace(part, parameters={}),), inputs=inputs), {part.name: known[path]}
            check_signals(in_declared_units(alone, described_alone), described_alone, refusals)
    refusals.raise_all(SystemDefinitionError)


def _system(scenario: Scenario, variant: Variant | None, options: RunOptions) -> System:
    """Return what is run: the scenario's system, functions in it, and values on top."""
    if not options.components and not options.connections:
        return scenario.system_of(variant, options.overrides)
    system = with_functions(scenario.system_of(variant), options.components or {}, options.connections)
    return system.with_values(options.overrides or {})


def _paths(system: System, packaging: str, folder: Path | None) -> dict[str, Path]:
    """Find the files of the components that are FMUs."""
    parts = [part for part in system.components if not callable(part.fmu)]
    return {part.name: locate_fmu(part.fmu, packaging, folder) for part in parts}


def _refuse_unrecorded(scenario: Scenario, signals: Sequence[str], names: Sequence[str]) -> None:
    """Refuse a figure of what is not recorded."""
    for signal in signals:
        if signal not in names:
            raise ScenarioError(
                f"{scenario.name}: figure.signals: '{signal}' is not recorded{suggestion(signal, names)}"
            )


def _opened(name: str, path: Path, description: Description, limits: Limits | None) -> AbstractContextManager[Slave]:
    """Open an FMU: in a process of its own if it is given limits, else in this one."""
    if limits is not None:
        from cosim.fmi2.isolation.isolated_slave import open_isolated_fmu

        return open_isolated_fmu(name, path, description, limits)
    from cosim.fmi2.fmu_slave import open_fmu

    return open_fmu(name, path, description)


def _turns(
    names: Sequence[str],
) -> tuple[Callable[[float], AbstractContextManager[None]], Callable[[], AbstractContextManager[None]]]:
    """Return the context of a turn of the FMUs in this process, which leaves that as it was; and `undisturbed`."""
    if not names:
        return lambda _: nullcontext(), nullcontext
    from cosim.fmi2.surroundings import Surroundings

    surroundings = Surroundings(names[0] if len(names) == 1 else f"one of {', '.join(names)}")

    def turn(now: float) -> AbstractContextManager[None]:
        return surroundings.kept(lambda: f"at t = {format_time(now)} s or in the steps after it")

    return turn, surroundings.undisturbed


def _isolated(system: System, isolate: bool | Collection[str]) -> frozenset[str]:
    """Return the names of the components to be isolated."""
    functions = functions_of(system)
    names = [part.name for part in system.components if part.name not in functions]
    wanted = (
        names if isolate is True else [] if isolate is False else [isolate] if isinstance(isolate, str) else isolate
    )
    asked = (*wanted, *(part.name for part in system.components if part.isolate))
    for name in asked:
        if name in functions:
            raise SystemDefinitionError(
                f"{name} is the Python function {functions[name].name}; expected an FMU to isolate"
            )
        if name not in names:
            raise SystemDefinitionError(f"there is no component '{name}' to isolate{suggestion(name, names)}")
    return frozenset(asked)


def modules_apart(paths: Mapping[str, Path], isolated: frozenset[str]) -> frozenset[str]:
    """Isolate as well what would run Python modules of another FMU, or of this program, in the place of its own."""
    from cosim.fmi2.python_modules import brought_modules, differing_module, hold

    brought = {path: brought_modules(path) for path in {*paths.values()}}
    apart: set[str] = set()
    for name, path in paths.items():
        if name in isolated:
            continue
        module = differing_module(brought[path])
        if module is None:
            hold(brought[path])
            continue
        apart.add(name)
        log.warning(
            "%s: %s brings a Python module '%s' that differs from the one of that name in this process; it is run in a "
            "process of its own",
            name,
            path.name,
            module,
        )
    return isolated | apart


@contextmanager
def _refused_with_others(
    system: System, paths: Mapping[str, Path], descriptions: Mapping[str, Description]
) -> Generator[None]:
    """Tell with an FMU that cannot be loaded what others cannot, and what else is wrong with the system."""
    from cosim.fmi2.archive import open_archive
    from cosim.fmi2.library import find_binary

    refusals = Refusals()
    with refusals.noted():
        yield
    if not refusals.found:
        return
    for name, path in paths.items():
        with refusals.noted(), open_archive(path) as archive:
            find_binary(archive, descriptions[name].model_identifier)
    with refusals.noted():
        check_system(system, descriptions)
    refusals.raise_all(type(refusals.found[0]))


def _tell_flaws(paths: Mapping[str, Path], descriptions: Mapping[str, Description]) -> None:
    """Say once for each file what it breaks, and that it is run nevertheless."""
    for path, name in {path: name for name, path in paths.items()}.items():
        known = descriptions[name]
        for where, flaws in ((" in modelDescription.xml", known.flaws), ("", known.archive_flaws)):
            more = f"; and {len(flaws) - _MOST_FLAWS} more flaws" if len(flaws) > _MOST_FLAWS else ""
            if flaws:
                log.warning("%s: tolerated%s: %s%s", path.name, where, "; ".join(flaws[:_MOST_FLAWS]), more)


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


def record_components(
    system: System, paths: Mapping[str, Path], descriptions: Mapping[str, Description]
) -> dict[str, dict[str, Any]]:
    """Say which file or function each component is, and every parameter it ran with, given or by default.

    What a signal drives is told among the inputs.
    """
    functions = functions_of(system)
    components: dict[str, dict[str, Any]] = {}
    for part in system.components:
        description = descriptions[part.name]
        file = paths.get(part.name)
        origin = functions[part.name].record() if file is None else _origin(file, description)
        fixed = [v for v in description.with_causality("parameter") if f"{part.name}.{v.name}" not in system.inputs]
        parameters = {variable.name: _start(variable) for variable in fixed}
        components[part.name] = {
            **origin,
            "parameters": {**parameters, **part.parameters},
        }
    return components


def _origin(path: Path, description: Description) -> dict[str, Any]:
    """Say which file, of any size, an FMU is."""
    with path.open("rb") as file:
        digest = digest_of(file)
    return {"model": description.model_name, "file": str(path), "sha256": digest.hex()}


def _start(variable: Variable) -> Value | None:
    """Return a start value, an enumeration's item by its name."""
    value = variable.start_value
    return value if value is None else _item(variable, value)


def _item(variable: Variable, value: Value) -> Value:
    """Return a value, an enumeration's item by its name."""
    if variable.type == "Enumeration":
        return next((name for name, number in variable.items.items() if number == value), value)
    return value
