"""What is coupled with what: a system as plain data.

Nothing here opens an FMU. Names are checked against the FMUs' model descriptions in `cosim.system.compatibility`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from cosim.errors import SystemDefinitionError, suggestion
from cosim.system.signals import Constant, Signal, Value

COUPLING = "coupling"
"""What stands before the dot in recorded names that tell of the coupling, where in others a component's name does."""


@dataclass(frozen=True)
class Component:
    """One FMU in a system.

    Parameters
    ----------
    name : str
        Name of the instance, without a dot.
    fmu : str or Path
        A name such as ``"DrillstringNeutral"``, looked up among the built FMUs, or the path of an .fmu file.
    parameters : mapping of str to float, int, bool or str
        Start values of parameters and of inputs that nothing drives. An enumeration takes an item's name or number.
    isolate : bool
        Run it in a process of its own, which may crash or hang without harm to the others.
    """

    name: str
    fmu: str | Path
    parameters: Mapping[str, Value] = field(default_factory=dict[str, Value])
    isolate: bool = False

    def __post_init__(self) -> None:
        if not self.name or "." in self.name:
            raise SystemDefinitionError(f"component '{self.name}': expected a name that is not empty and has no dot")
        if self.name == COUPLING:
            raise SystemDefinitionError(f"component '{COUPLING}': records use this name for the coupling itself")
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))


@dataclass(frozen=True)
class Connection:
    """An output that drives an input, each written ``component.variable``."""

    source: str
    target: str

    def __post_init__(self) -> None:
        for end in (self.source, self.target):
            split_name(end)


@dataclass(frozen=True)
class PowerBond:
    """Power that a component takes in: an input and an output of it, of which the product is a power.

    The input is driven by a connection. If the output in turn drives the component that the input comes from, the two
    connections exchange the power; if not, that component is taken to give it at the output's own value.
    """

    input: str
    output: str

    def __post_init__(self) -> None:
        first, second = split_name(self.input)[0], split_name(self.output)[0]
        if first != second:
            raise SystemDefinitionError(
                f"power bond {self.input}, {self.output}: {second} is another component; expected an output of {first}"
            )


@dataclass(frozen=True)
class System:
    """Components, the connections between them, and the signals that drive the inputs left over.

    Parameters
    ----------
    components : tuple of Component
        In the order of the record; where nothing else decides, they are stepped in it too.
    connections : tuple of Connection
        Each input is driven at most once.
    inputs : mapping of str to Signal
        Signals by the name ``component.variable`` of the input they drive.
    guards : tuple of str, optional
        Boolean outputs that say that a value is a guard's or a limit's; by default those whose names end in
        ``_active``.
    power_bonds : tuple of PowerBond, optional
        Where power is exchanged; by default what units and connections tell.

    Raises
    ------
    SystemDefinitionError
        If there is no component, two have one name, a connection, input, guard or power bond names none, or an input
        is driven twice.
    """

    components: tuple[Component, ...]
    connections: tuple[Connection, ...] = ()
    inputs: Mapping[str, Signal] = field(default_factory=dict[str, Signal])
    guards: tuple[str, ...] | None = None
    power_bonds: tuple[PowerBond, ...] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "inputs", MappingProxyType(dict(self.inputs)))
        names = [component.name for component in self.components]
        if not names:
            raise SystemDefinitionError("the system has no component")
        for name in names:
            if names.count(name) > 1:
                raise SystemDefinitionError(f"component '{name}' is declared {names.count(name)} times; expected once")
        for connection in self.connections:
            self.component_of(connection.source)
            self.component_of(connection.target)
        for name in (*self.inputs, *(self.guards or ()), *(bond.input for bond in self.power_bonds or ())):
            self.component_of(name)
        self._refuse_double_drives()

    def component_of(self, name: str) -> Component:
        """Return the component that ``component.variable`` belongs to, or refuse the name."""
        wanted, _ = split_name(name)
        for component in self.components:
            if component.name == wanted:
                return component
        known = [component.name for component in self.components]
        raise SystemDefinitionError(f"{name}: there is no component '{wanted}'{suggestion(wanted, known)}")

    def with_values(self, values: Mapping[str, Value]) -> System:
        """Return the system with parameters, or inputs that no connection drives, set to other values.

        Parameters
        ----------
        values : mapping of str to float, int, bool or str
            By ``component.variable``. A value for an input replaces its signal by a constant.
        """
        inputs = dict(self.inputs)
        parameters = {component.name: dict(component.parameters) for component in self.components}
        for name, value in values.items():
            component, variable = self.component_of(name).name, split_name(name)[1]
            if name in inputs and isinstance(value, str):
                raise SystemDefinitionError(f"{name}: value is '{value}'; expected a number or a Boolean")
            if name in inputs and not isinstance(value, str):
                inputs[name] = Constant(value)
            else:
                parameters[component][variable] = value
        components = tuple(replace(component, parameters=parameters[component.name]) for component in self.components)
        return replace(self, components=components, inputs=inputs)

    def _refuse_double_drives(self) -> None:
        """Refuse an input that two connections, or a connection and a signal, drive."""
        drivers: dict[str, str] = dict.fromkeys(self.inputs, "a signal")
        for connection in self.connections:
            if connection.target in drivers:
                first = drivers[connection.target]
                raise SystemDefinitionError(
                    f"{connection.target} is driven by {first} and by {connection.source}; expected one source"
                )
            drivers[connection.target] = connection.source


def split_name(name: str) -> tuple[str, str]:
    """Split ``component.variable`` at its first dot.

    Raises
    ------
    SystemDefinitionError
        If there is no dot, or nothing on one side of it.
    """
    component, _, variable = name.partition(".")
    if not component or not variable:
        raise SystemDefinitionError(f"'{name}': expected the form component.variable")
    return component, variable
