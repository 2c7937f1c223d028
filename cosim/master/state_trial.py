"""A trial of the states that a run is going to return to: the first step, taken twice from the same state.

An FMU may declare that it can get and set its state, and lose a part of it: a delay line, or a value it has computed.
Then a repeated step begins somewhere else, and what comes of it is wrong without any sign. A trial at the start costs
two steps, and leaves nothing: the state is restored, and so is the memory in which values are exchanged.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cosim.errors import SlaveError, SystemDefinitionError, format_time
from cosim.master.wiring import Node
from cosim.recording.record import BASE_TYPES

_BEFORE, _AFTER = 0, 1
_SLOT = 0
_STATE_FUNCTIONS = ("fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate")


def try_states(nodes: Iterable[Node], time: float, size: float) -> None:
    """Refuse components that do not repeat a step from the state that they have saved before it.

    Parameters
    ----------
    nodes : iterable of Node
        Initialised, at the time `time` [s], with consistent values in row 0; they are so again afterwards.
    time, size : float
        Communication point and size of the first step, s.

    Raises
    ------
    SystemDefinitionError
        Naming the first component whose outputs are others the second time, or that fails to save or restore.
    SlaveError
        If a component fails in the step itself. One that discards it has shown nothing.
    """
    for node in nodes:
        memory = node.block.arrays()
        kept = [values.copy() for values in memory]
        try:
            _try_state(node, time, size)
        except SlaveError as error:
            if error.function not in _STATE_FUNCTIONS:
                raise
            raise _refusal(node, f"{error.function} returned {error.status} at t = {format_time(time)} s") from None
        finally:
            for values, before in zip(memory, kept, strict=True):
                values[:] = before


def _try_state(node: Node, time: float, size: float) -> None:
    """Take a step, return, take it again, compare, and return."""
    node.slave.save(_SLOT)
    first = _outputs_after(node, time, size)
    node.slave.restore(_SLOT)
    if first is None:
        return
    second = _outputs_after(node, time, size)
    node.slave.restore(_SLOT)
    step = f"from the same state, the step from t = {format_time(time)} s to {format_time(time + size)} s"
    if second is None:
        raise _refusal(node, f"{step} was taken, and then discarded")
    for name, value in first.items():
        if _bits(value) != _bits(second[name]):
            raise _refusal(node, f"{step} gave {name} = {value!s}, and then {second[name]!s}")


def _bits(value: np.generic | str) -> bytes:
    """Return what tells a value from any other: of a number its bits."""
    return value.encode() if isinstance(value, str) else value.tobytes()


def _outputs_after(node: Node, time: float, size: float) -> dict[str, np.generic | str] | None:
    """Take a step with the inputs as they are, and return outputs and derivatives by name; None if it is discarded."""
    node.slave.write(_BEFORE)
    try:
        node.slave.step(time, size)
    except SlaveError as error:
        if not error.discarded:
            raise
        return None
    node.slave.read(_AFTER)
    sections = [node.block.outputs[kind] for kind in BASE_TYPES]
    found = {
        variable.name: section.values[_AFTER, column]
        for section in sections
        for column, variable in enumerate(section.variables)
    }
    slopes = node.block.output_slopes
    if slopes is not None:
        found |= {f"derivative {number}": value for number, value in enumerate(slopes.values[_AFTER].copy(), 1)}
    return found


def _refusal(node: Node, what: str) -> SystemDefinitionError:
    """Say that a component does not do what it declares."""
    return SystemDefinitionError(
        f"{node.name} ({node.slave.description.model_name}) cannot return to an earlier state, although it declares so "
        f"(canGetAndSetFMUstate is true): {what}"
    )
