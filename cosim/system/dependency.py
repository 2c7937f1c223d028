"""Find what depends on what in a system: algebraic loops, and the order in which to step the components.

An output depends directly on the inputs that the FMU's ModelStructure names, and an input on the output it is connected
to. A cycle of such dependencies is an algebraic loop: no order of steps can give every component the newest values.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from cosim.errors import SystemDefinitionError, suggestion
from cosim.system.description import Description
from cosim.system.structure import Connection, Port, System

_Node = TypeVar("_Node", bound=str)
_Edges = Mapping[_Node, frozenset[_Node]]


@dataclass(frozen=True)
class Loop:
    """An algebraic loop.

    Attributes
    ----------
    path : tuple of Port
        A shortest way round; the first follows from the last.
    variables : frozenset of Port
        Everything that depends on itself together with them.
    """

    path: tuple[Port, ...]
    variables: frozenset[Port]

    def __str__(self) -> str:
        return " -> ".join((*self.path, self.path[0]))


@dataclass(frozen=True)
class SteppingGroup:
    """Components to be stepped together.

    Attributes
    ----------
    components : tuple of str
        In stepping order.
    coupled : bool
        Whether they depend on each other, so that none can be stepped before the others.
    """

    components: tuple[str, ...]
    coupled: bool


def feedthrough_loops(
    system: System, descriptions: Mapping[str, Description], *, initially: bool = False
) -> tuple[Loop, ...]:
    """Find the algebraic loops of a system.

    Parameters
    ----------
    system : System
        Checked by `cosim.system.compatibility.check_system`.
    descriptions : mapping of str to Description
        By name of component.
    initially : bool
        Whether to look at the dependencies of initialization mode (InitialUnknowns) instead of those of a step.
    """
    edges = _variable_edges(system, descriptions, initially)
    loops: list[Loop] = []
    for connection in system.connections:
        variable = connection.target
        cycle = _cycle(variable, edges)
        if cycle and not any(variable in loop.variables for loop in loops):
            loops.append(Loop(_shortest_cycle(variable, edges), cycle))
    return tuple(loops)


def feedthrough_reach(system: System, descriptions: Mapping[str, Description]) -> dict[Port, frozenset[Port]]:
    """Find what changes at once with an input.

    Returns
    -------
    dict of Port to frozenset of Port
        By driven input, the connected inputs that depend on it directly, through any number of
        components. On a tunable parameter all outputs of its component may depend: descriptions do not tell.
    """
    edges = {name: set(targets) for name, targets in _variable_edges(system, descriptions, initially=False).items()}
    sources = {connection.source for connection in system.connections}
    for port in system.inputs:
        description = descriptions[port.component]
        outputs = {source for source in sources if source.component == port.component}
        tuned = description.by_name[port.variable].tunable
        edges[port] = {each for each in outputs if tuned or port.variable in description.fed_through(each.variable)}
    frozen = {name: frozenset(targets) for name, targets in edges.items()}
    inputs = {connection.target for connection in system.connections}
    return {name: _reachable(name, frozen) & inputs for name in (*inputs, *system.inputs)}


def stepping_groups(
    system: System, descriptions: Mapping[str, Description], connections: Iterable[Connection]
) -> tuple[SteppingGroup, ...]:
    """Derive a stepping order: what is depended on comes first, and what depends on each other forms a group.

    In a group something has to be stepped with old values. It is the component through which a connection within the
    group does not feed through to another, if there is one, since there an old value does least harm; else the one that
    is listed first. The order of the others follows in the same way.

    Parameters
    ----------
    system : System
        Checked by `cosim.system.compatibility.check_system`; of independent components, those listed first come first.
    descriptions : mapping of str to Description
        By name of component.
    connections : iterable of Connection
        Those of the system's connections that count.
    """
    names = [component.name for component in system.components]
    counted = tuple(connections)
    edges = _component_edges(names, counted)
    groups = _groups(names, edges)
    through = {name: _feeds_through(name, group, counted, descriptions) for group in groups for name in group}
    leading_back = {name for name in names if name in _reachable(name, edges)}
    return tuple(SteppingGroup(_ordered(group, edges, through), leading_back.issuperset(group)) for group in groups)


def stepping_order(
    system: System, descriptions: Mapping[str, Description], given: Sequence[str] = ()
) -> tuple[str, ...]:
    """Return all components in the order in which to step them: the given one, or else one derived.

    Raises
    ------
    SystemDefinitionError
        If the given order leaves out a component or names one that does not exist or twice.
    """
    if not given:
        groups = stepping_groups(system, descriptions, system.connections)
        return tuple(name for group in groups for name in group.components)
    names = [component.name for component in system.components]
    for name in given:
        if name not in names:
            raise SystemDefinitionError(f"order: there is no component '{name}'{suggestion(name, names)}")
    if sorted(given) != sorted(names):
        raise SystemDefinitionError(f"order is {', '.join(given)}; expected each of {', '.join(names)} once")
    return tuple(given)


def moves(connection: Connection, descriptions: Mapping[str, Description]) -> bool:
    """Tell whether a connection passes what changes continuously, which alone can be iterated and extrapolated."""
    ends = (connection.source, connection.target)
    return all(descriptions[port.component].by_name[port.variable].is_continuous for port in ends)


def _variable_edges(system: System, descriptions: Mapping[str, Description], initially: bool) -> _Edges[Port]:
    """Lead from each connected output to the inputs it drives, and from those to the outputs they feed through to."""
    leads: dict[Port, set[Port]] = {}
    for connection in system.connections:
        leads.setdefault(connection.source, set()).add(connection.target)
        leads.setdefault(connection.target, set())
    for connection in system.connections:
        source = connection.source
        for name in descriptions[source.component].fed_through(source.variable, initially=initially):
            fed = Port(source.component, name)
            if fed in leads:
                leads[fed].add(source)
    return {name: frozenset(targets) for name, targets in leads.items()}


def _component_edges(names: Sequence[str], connections: Iterable[Connection]) -> _Edges[str]:
    """Lead from each component to those it drives."""
    leads: dict[str, set[str]] = {name: set() for name in names}
    for connection in connections:
        leads[connection.source.component].add(connection.target.component)
    return {name: frozenset(targets) for name, targets in leads.items()}


def _feeds_through(
    name: str, group: Sequence[str], connections: Iterable[Connection], descriptions: Mapping[str, Description]
) -> bool:
    """Tell whether a component passes something on within its group without a step between."""
    within = [c for c in connections if c.source.component in group and c.target.component in group]
    inputs = {c.target.variable for c in within if c.target.component == name}
    outputs = {c.source.variable for c in within if c.source.component == name}
    return any(descriptions[name].fed_through(output) & inputs for output in outputs)


def _groups(names: Sequence[str], edges: _Edges[str]) -> list[tuple[str, ...]]:
    """Gather nodes that lead to each other, and put the groups into an order in which none leads back."""
    groups: list[tuple[str, ...]] = []
    left = list(names)
    while left:
        reach = {name: _reachable(name, edges) for name in left}
        sources = {name: [other for other in left if name in reach[other]] for name in left}
        first = next(name for name in left if all(other in reach[name] for other in sources[name]))
        group = tuple(name for name in left if name == first or (name in reach[first] and first in reach[name]))
        groups.append(group)
        left = [name for name in left if name not in group]
    return groups


def _ordered(group: Sequence[str], edges: _Edges[str], through: Mapping[str, bool]) -> tuple[str, ...]:
    """Order nodes that lead to each other: one first, and the others as if nothing led to it."""
    if len(group) == 1:
        return tuple(group)
    first = min(group, key=lambda name: (through[name], group.index(name)))
    others = [name for name in group if name != first]
    inner = {name: edges[name] & set(others) for name in others}
    return (first, *(name for part in _groups(others, inner) for name in _ordered(part, inner, through)))


def _reachable(start: _Node, edges: _Edges[_Node]) -> frozenset[_Node]:
    """Return where one gets from a node, in one step or more."""
    seen: set[_Node] = set()
    ahead = list(edges[start])
    while ahead:
        node = ahead.pop()
        if node not in seen:
            seen.add(node)
            ahead.extend(edges[node])
    return frozenset(seen)


def _cycle(node: _Node, edges: _Edges[_Node]) -> frozenset[_Node]:
    """Return the nodes that lead to a node and are led to by it; nothing if it does not lead to itself."""
    return frozenset(other for other in _reachable(node, edges) if node in _reachable(other, edges))


def _shortest_cycle(start: _Node, edges: _Edges[_Node]) -> tuple[_Node, ...]:
    """Return a shortest way from a node back to it, by breadth-first search."""
    ways: deque[tuple[_Node, ...]] = deque([(start,)])
    seen: set[_Node] = set()
    while ways:
        way = ways.popleft()
        for node in sorted(edges[way[-1]]):
            if node == start:
                return way
            if node not in seen:
                seen.add(node)
                ways.append((*way, node))
    raise ValueError(f"no way leads from {start} back to it")
