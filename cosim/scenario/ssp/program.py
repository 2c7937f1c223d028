"""Turn signals into components and back: SSP knows no signals, so that a `DrillingProgram` puts out what they are.

One change from an initial to a final value, at once or along a straight line, is what the parameters of a
`DrillingProgram` can say; a constant is no change. The component carries an annotation, by which it turns into signals
again when the file is read: these jump and bend at communication points of their own, whatever the algorithm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from cosim.errors import SspError
from cosim.system.description import Description
from cosim.system.signals import Change, Signal, Value, signal_of_change
from cosim.system.structure import Component, Connection, Port, System

MODEL = "DrillingProgram"
_CHANGE_OF = {"Omega": "speed", "speed_ref": "speed", "bit_speed_ref": "speed", "WOB": "WOB"}
_PARTS = ("initial", "final", "start", "duration")


@dataclass
class _Program:
    """The changes one component makes, and the inputs it drives."""

    changes: dict[str, Change] = field(default_factory=dict[str, Change])
    targets: list[Port] = field(default_factory=list[Port])


def as_components(system: System) -> tuple[System, frozenset[str]]:
    """Return a system in which components do what signals did, and the names of these components, which come first.

    A constant that no output of a `DrillingProgram` fits becomes the start value of an input that nothing drives, which
    is the same.

    Raises
    ------
    SspError
        If a signal can be neither.
    """
    programs: list[_Program] = []
    values: dict[str, Value] = {}
    for target, signal in system.inputs.items():
        change = signal.change if target.variable in _CHANGE_OF else None
        if change is not None:
            _place(programs, target, change)
        elif signal.held is not None:
            values[target] = signal.held
        else:
            raise SspError(
                f"{target} is driven by a {signal.kind}; SSP can hold constants, and for the inputs "
                f"{', '.join(_CHANGE_OF)} steps and ramps as well"
            )
    names = _names(system, len(programs))
    added = tuple(Component(name, MODEL, _parameters(part.changes)) for name, part in zip(names, programs, strict=True))
    connections = [
        Connection(Port(name, target.variable), target)
        for name, part in zip(names, programs, strict=True)
        for target in part.targets
    ]
    bare = System(system.components, system.connections).with_values(values)
    return System((*added, *bare.components), (*connections, *bare.connections)), frozenset(names)


def as_signals(system: System, marked: Mapping[str, Description]) -> System:
    """Undo `as_components`.

    Parameters
    ----------
    system : System
        Without signals.
    marked : mapping of str to Description
        The components that stand for signals.

    Raises
    ------
    SspError
        If a marked component does something that signals cannot.
    """
    inputs: dict[Port, Signal] = {}
    for component in system.components:
        if component.name in marked:
            inputs |= _signals(component, system.connections, marked[component.name])
    components = tuple(component for component in system.components if component.name not in marked)
    connections = tuple(c for c in system.connections if c.source.component not in marked)
    return System(components, connections, inputs)


def _place(programs: list[_Program], target: Port, change: Change) -> None:
    """Let the first program that can, or else a new one, make the change."""
    part = _CHANGE_OF[target.variable]
    for program in programs:
        if program.changes.get(part, change) == change:
            break
    else:
        program = _Program()
        programs.append(program)
    program.changes[part] = change
    program.targets.append(target)


def _names(system: System, count: int) -> list[str]:
    """Choose names that are free."""
    taken = {component.name for component in system.components}
    free = (name for name in ("program", *(f"program_{n}" for n in range(2, 1000))) if name not in taken)
    return [next(free) for _ in range(count)]


def _parameters(changes: Mapping[str, Change]) -> dict[str, Value]:
    """Write changes as parameters."""
    return {
        f"{part}_{name}": number
        for part, change in changes.items()
        for name, number in zip(_PARTS, change, strict=True)
    }


def _signals(component: Component, connections: Sequence[Connection], description: Description) -> dict[Port, Signal]:
    """Read the signals that a component stands for."""
    label = f"{component.name} is marked as standing for signals"
    signals: dict[Port, Signal] = {}
    for name in component.parameters:
        if name.rpartition("_")[0] not in _CHANGE_OF.values():
            raise SspError(f"{label}, but sets {name}; expected parameters of the changes of speed and WOB only")
    for connection in connections:
        output = connection.source.variable
        if connection.target.component == component.name:
            raise SspError(f"{label}, but {connection.source} drives {connection.target}; expected no input")
        if connection.source.component != component.name:
            continue
        if output not in _CHANGE_OF:
            raise SspError(f"{label}, but puts out {output}; expected one of {', '.join(_CHANGE_OF)}")
        names = [f"{_CHANGE_OF[output]}_{part}" for part in _PARTS]
        numbers = [component.parameters.get(name, _start(name, description)) for name in names]
        signals[connection.target] = _signal(label, output, numbers)
    return signals


def _start(name: str, description: Description) -> Value | None:
    """Return the start value of a parameter, if there is one and it is a number."""
    variable = description.by_name.get(name)
    return variable.start_value if variable and variable.type == "Real" else None


def _signal(label: str, output: str, numbers: Sequence[Value | None]) -> Signal:
    """Make a signal of the parameters of a change."""
    initial, final, start, duration = (
        number if isinstance(number, int | float) and not isinstance(number, bool) else None for number in numbers
    )
    if initial is None or final is None or start is None or duration is None:
        raise SspError(f"{label}, but a parameter of the change of {_CHANGE_OF[output]} is not a number")
    return signal_of_change((initial, final, start, duration))
