"""Show what an FMU or a scenario is made of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from cosim.errors import ScenarioError, printable, suggestion
from cosim.fmi2.locate import locate_fmu, promised_fmus
from cosim.fmi2.model_description import read_description
from cosim.run.assembly import described
from cosim.run.options import RunOptions
from cosim.scenario.file import opened_scenario, scenario_names
from cosim.scenario.scenario import Scenario
from cosim.system.dependency import feedthrough_loops, stepping_order
from cosim.system.description import Description, Variable
from cosim.system.signals import Signal
from cosim.system.structure import Port

_HEADINGS = ("variable", "causality", "variability", "type", "unit", "start", "range", "description")
_SHORTEST = 8
"""Numbers of a signal that are shown."""


def print_information(console: Console, what: str, packaging: str, variant: str | None) -> None:
    """Show what an FMU or a scenario is made of.

    Parameters
    ----------
    console : rich.console.Console
        Where to write.
    what : str
        An .fmu file, the name of an FMU or of a scenario, or a .toml or .ssp file.
    packaging : str
        Of FMUs that are given by name.
    variant : str, optional
        Of a scenario; by default the first.

    Raises
    ------
    InputError
        If there is no such thing, or it cannot be read.
    """
    fmus, scenarios = promised_fmus(packaging), scenario_names()
    if Path(what).suffix == ".fmu" or what in fmus:
        path = locate_fmu(what, packaging)
        _print_fmu(console, path, read_description(path))
        return
    if not Path(what).suffix and what not in scenarios:
        raise ScenarioError(f"there is no FMU or scenario '{what}'{suggestion(what, [*fmus, *scenarios])}")
    with opened_scenario(what) as scenario:
        _print_scenario(console, scenario, RunOptions(packaging=packaging, variant=variant))


def _print_fmu(console: Console, path: Path, description: Description) -> None:
    """Show capabilities and variables of an FMU."""
    _line(console, description.model_name, style="bold")
    _line(console, f"file: {path}")
    if description.generation_tool:
        _line(console, f"made by: {description.generation_tool}")
    abilities = {
        "variable step size": description.can_vary_step,
        "interpolated inputs": description.can_interpolate_inputs,
        "saved states": description.can_save_state,
        "serialized states": description.can_serialize_state,
        "output derivatives": description.output_derivative_order > 0,
    }
    _line(console, f"capabilities: {_listed(name for name, there in abilities.items() if there) or 'none'}")
    if description.once_per_process:
        _line(console, "it can be instantiated only once in a process")
    for flaw in (*description.flaws, *description.archive_flaws):
        _line(console, f"note: {flaw}")
    console.print(_variables(description.variables))


def _variables(variables: Iterable[Variable]) -> Table:
    """Tabulate variables."""
    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    for heading in _HEADINGS:
        table.add_column(heading, no_wrap=heading == _HEADINGS[0], overflow="fold")
    for each in variables:
        unit = each.unit.name if each.unit is not None else ""
        cells = (each.name, each.causality, each.variability, _type(each), unit, each.start or "", _range(each))
        table.add_row(*(Text(printable(cell)) for cell in (*cells, each.description)))
    return table


def _type(variable: Variable) -> str:
    """Name the type, of an enumeration with its items."""
    return f"{variable.type} ({', '.join(variable.items)})" if variable.items else variable.type


def _range(variable: Variable) -> str:
    """Write the declared range."""
    low, high = variable.minimum, variable.maximum
    if low is None and high is None:
        return ""
    if low is None:
        return f"<= {high:.12g}"
    return f">= {low:.12g}" if high is None else f"{low:.12g} to {high:.12g}"


def _print_scenario(console: Console, scenario: Scenario, options: RunOptions) -> None:
    """Show components, connections, inputs, loops and stepping of a scenario."""
    system, descriptions, paths = described(scenario, options)
    method = options.method(scenario)
    _line(console, scenario.title or scenario.name, style="bold")
    _line(console, f"from {scenario.start_time:g} s to {scenario.stop_time:g} s in steps of {scenario.step_size:g} s")
    if scenario.variants:
        _line(console, f"variants: {_listed(each.name for each in scenario.variants)}")
    _line(console, "components:")
    for part in system.components:
        given = "".join(f", {name} = {value}" for name, value in part.parameters.items())
        _line(console, f"  {part.name}: {descriptions[part.name].model_name}{given}")
        _line(console, f"    file: {paths[part.name]}")
    _print_ways(console, [f"{each.source} -> {each.target}" for each in system.connections], "connections")
    _print_ways(console, [f"{port} = {_short(signal)}" for port, signal in system.inputs.items()], "inputs")
    _print_ways(console, list(map(str, feedthrough_loops(system, descriptions))), "algebraic loops")
    order = _listed(stepping_order(system, descriptions, method.order))
    _line(console, f"algorithm: {method.algorithm}; order of steps: {order}")
    _print_open(console, system.inputs, {str(each.target) for each in system.connections}, descriptions)


def _print_open(
    console: Console, inputs: Mapping[Port, Signal], driven: set[str], descriptions: Mapping[str, Description]
) -> None:
    """Show inputs that nothing drives, which keep their start values."""
    open_ = [
        f"{name}.{each.name} = {each.start}{f' {each.unit.name}' if each.unit else ''}"
        for name, description in descriptions.items()
        for each in description.with_causality("input")
        if f"{name}.{each.name}" not in driven and Port(name, each.name) not in inputs
    ]
    _print_ways(console, open_, "inputs at their start values")


def _print_ways(console: Console, lines: list[str], heading: str) -> None:
    """Show lines below a heading, if there are any."""
    if lines:
        _line(console, f"{heading}:")
    for line in lines:
        _line(console, f"  {line}")


def _short(signal: Signal) -> str:
    """Write a signal: its value if it is constant, else its kind and its first numbers."""
    if signal.held is not None:
        return str(signal.held)
    parts = {name: value for name, value in signal.record().items() if name != "kind"}
    return f"{signal.kind} ({', '.join(f'{name} {_cut(value)}' for name, value in parts.items())})"


def _cut(value: object) -> str:
    """Write a number, or the first of many."""
    if isinstance(value, tuple | list):
        shown = [str(each) for each in value[:_SHORTEST]]  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
        return ", ".join(shown) + (" ..." if len(value) > _SHORTEST else "")  # pyright: ignore[reportUnknownArgumentType]
    return str(value)


def _listed(names: Iterable[str]) -> str:
    """Write names one after the other."""
    return ", ".join(names)


def _line(console: Console, text: str, style: str = "") -> None:
    """Write one line, however long."""
    console.print(Text(text, style=style), soft_wrap=True)
