"""Which components have to return to an earlier state, and refusing those that have to and cannot."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from cosim.errors import SystemDefinitionError
from cosim.system.dependency import Group, stepping_groups, stepping_order
from cosim.system.description import Description
from cosim.system.method import Method
from cosim.system.structure import Connection, System, split_name


@dataclass(frozen=True)
class RollbackPlan:
    """A plan for steps that may be repeated.

    Attributes
    ----------
    groups : tuple of Group
        Components in stepping order; those of a coupled group are repeated until their values agree.
    last : tuple of str
        Components stepped when a step is kept, as they cannot be taken back.
    saved : tuple of str
        Components whose states are kept at the beginning of a step.
    """

    groups: tuple[Group, ...]
    last: tuple[str, ...]
    saved: tuple[str, ...]


def plan_rollback(system: System, descriptions: Mapping[str, Description], method: Method) -> RollbackPlan:
    """Decide which components are repeated, and refuse those that have to be and cannot.

    An FMU that cannot return to an earlier state can still take part outside of loops: with steps that are never taken
    back as any other, and otherwise if nothing depends on it.

    Raises
    ------
    SystemDefinitionError
        Naming the components that lack a capability, and what they lack it for.
    """
    if method.implicit:
        continuous = [connection for connection in system.connections if _moves(connection, descriptions)]
        groups = stepping_groups(system, descriptions, continuous)
    else:
        groups = tuple(Group((name,), False) for name in stepping_order(system, descriptions, method.order))
    for group in groups:
        if group.coupled:
            what = f"the {method.algorithm} algorithm repeats the steps of {_list(group.components)}"
            _require_state(what, group.components, descriptions)
    coupled = tuple(name for group in groups if group.coupled for name in group.components)
    if not method.takes_back:
        return RollbackPlan(groups, (), coupled)
    why = "with a tolerance" if method.tolerance is not None else "to halve steps"
    _require_variable_step(why, descriptions)
    needed = {split_name(connection.source)[0] for connection in system.connections}
    last = tuple(
        name for name, description in descriptions.items() if not (description.can_save_state or name in needed)
    )
    saved = tuple(name for group in groups for name in group.components if name not in last)
    _require_state(f"{why}, steps are taken back", saved, descriptions)
    return RollbackPlan(tuple(group for group in groups if group.components[0] not in last), last, saved)


def _moves(connection: Connection, descriptions: Mapping[str, Description]) -> bool:
    """Whether a connection passes what changes continuously."""
    ends = (split_name(end) for end in (connection.source, connection.target))
    variables = [descriptions[component].by_name[name] for component, name in ends]
    return all(variable.type == "Real" and variable.variability == "continuous" for variable in variables)


def _require_state(what: str, names: Iterable[str], descriptions: Mapping[str, Description]) -> None:
    """Refuse FMUs that cannot return to an earlier state."""
    unable = [name for name in names if not descriptions[name].can_save_state]
    if unable:
        models = _list(f"{name} ({descriptions[name].model_name})" for name in unable)
        raise SystemDefinitionError(
            f"{what}, but {models} cannot return to an earlier state (canGetAndSetFMUstate is false)"
        )


def _require_variable_step(why: str, descriptions: Mapping[str, Description]) -> None:
    """Refuse FMUs of fixed step."""
    unable = [name for name, description in descriptions.items() if not description.can_vary_step]
    if unable:
        models = _list(f"{name} ({descriptions[name].model_name})" for name in unable)
        raise SystemDefinitionError(
            f"{why}, steps vary in size, but {models} cannot do that (canHandleVariableCommunicationStepSize is false)"
        )


def _list(names: Iterable[str]) -> str:
    """Join names as in a sentence."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last
