"""Find where components exchange power: connections whose value, times another, is a power.

Speed and torque, or velocity and force, are such pairs. `cosim.master.observation` accounts for energy across them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from cosim.errors import SystemDefinitionError, suggestion
from cosim.system.conversion import Conversion, conversion_of
from cosim.system.dependency import stepping_groups
from cosim.system.description import Description, Unit, Variable, describe
from cosim.system.structure import Connection, Port, PowerBond, System

# Exponents of kg, m, s, A, K, mol, cd; angles do not count.
_WATT = (1, 2, -3, 0, 0, 0, 0)


@dataclass(frozen=True)
class Bond:
    """A power bond with both its ends.

    Attributes
    ----------
    input, output : Port
        Of the component that takes the power in.
    source : Port
        The output that drives `input`.
    back : Port or None
        The input of the same component as `source` that `output` drives, if there is one.
    factor : float
        From the product of the values to W.
    conversion : Conversion, optional
        What becomes of the value of `source` on its way to `input`.
    given_factor : float, optional
        From the product of the values of `source` and `back` to W, where it is another.
    """

    input: Port
    output: Port
    source: Port
    back: Port | None
    factor: float
    conversion: Conversion | None = None
    given_factor: float | None = None


def find_bonds(system: System, descriptions: Mapping[str, Description]) -> tuple[Bond, ...]:
    """Return the power bonds of a system: those it names, or else those that its units and connections tell.

    Told is a bond by a connected input and an output of the same component whose product is a power, if that is the
    only output to drive the component the input comes from. Where there is none, it may be the only one that the input
    feeds through to, as long as the two components depend on each other; else it is a signal like any other.

    Raises
    ------
    SystemDefinitionError
        If a bond that is named does not exist or is none.
    """
    if system.power_bonds is not None:
        return tuple(_named(bond, system, descriptions) for bond in system.power_bonds)
    bonds: dict[frozenset[str], Bond] = {}
    groups = [group.components for group in stepping_groups(system, descriptions, system.connections)]
    for connection in system.connections:
        bond = _told(connection, system, descriptions, groups)
        if bond is not None:
            bonds.setdefault(frozenset((bond.source, bond.output)), bond)
    return tuple(bonds.values())


def _told(
    connection: Connection,
    system: System,
    descriptions: Mapping[str, Description],
    groups: Iterable[Collection[str]],
) -> Bond | None:
    """Find the output that goes with a connected input, if there is no doubt about it."""
    source, target = connection.source, connection.target
    component, name = target.component, target.variable
    description = descriptions[component]
    variable = description.by_name[name]
    outputs = {
        Port(component, output.name): factor
        for output in description.with_causality("output")
        for factor in [_watts(variable, output)]
        if factor
    }
    giver = source.component
    pairs = [output for output in outputs if giver != component and _back(output, giver, system)]
    coupled = any(giver in group and component in group for group in groups)
    through = [output for output in outputs if name in description.fed_through(output.variable)]
    chosen = pairs or (through if coupled else [])
    if len(chosen) != 1:
        return None
    return _bond(connection, chosen[0], outputs[chosen[0]], system, descriptions)


def _named(bond: PowerBond, system: System, descriptions: Mapping[str, Description]) -> Bond:
    """Check a bond that the system names."""
    component = bond.input.component
    description = descriptions[component]
    for name, causality in ((bond.input, "input"), (bond.output, "output")):
        known = [Port(component, variable.name) for variable in description.with_causality(causality)]
        if name not in known:
            raise SystemDefinitionError(f"power bond: {name} is no {causality}{suggestion(name, known)}")
    connection = next((one for one in system.connections if one.target == bond.input), None)
    if connection is None:
        raise SystemDefinitionError(f"power bond: {bond.input} is not connected; expected an input with a source")
    first, second = (description.by_name[port.variable] for port in (bond.input, bond.output))
    factor = _watts(first, second)
    if factor is None:
        raise SystemDefinitionError(
            f"power bond: {bond.input} in {describe(first.unit)} times {bond.output} in {describe(second.unit)} "
            "is no power"
        )
    return _bond(connection, bond.output, factor, system, descriptions)


def _bond(
    connection: Connection, output: Port, factor: float, system: System, descriptions: Mapping[str, Description]
) -> Bond:
    """Make a bond of the connection that leads to its input, with what becomes of its values on both ways.

    Where values are converted, the component that gives the power counts it in units of its own; where these are not
    known to make a power, they are taken for those of the component that takes it.
    """
    source = connection.source
    back = _back(output, source.component, system)
    ways = [each for each in system.connections if each.target in (connection.target, back)]
    given_factor: float | None = None
    if back is not None and any(conversion_of(way, descriptions) is not None for way in ways):
        ends = (descriptions[port.component].by_name[port.variable] for port in (source, back))
        given_factor = _watts(*ends)
    return Bond(connection.target, output, source, back, factor, conversion_of(connection, descriptions), given_factor)


def _back(output: Port, giver: str, system: System) -> Port | None:
    """Return the input of a component that an output drives."""
    targets = (connection.target for connection in system.connections if connection.source == output)
    return next((target for target in targets if target.component == giver), None)


def _watts(first: Variable, second: Variable) -> float | None:
    """Return the factor from the product of two variables to W, or None if it is no power."""
    units: list[Unit] = [variable.unit for variable in (first, second) if variable.unit is not None]
    if len(units) < 2 or any(unit.powers is None or unit.offset for unit in units):
        return None
    powers = tuple(a + b for a, b in zip(units[0].powers or (), units[1].powers or (), strict=True))
    return units[0].factor * units[1].factor if powers[:-1] == _WATT else None
