"""State what is coupled with what: a system as plain data.

Nothing here opens an FMU. Names are checked against the FMUs' model descriptions in `cosim.system.compatibility`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Never, cast

from cosim.errors import SystemDefinitionError, suggestion
from cosim.system.signals import Constant, Signal, Value, plain_value

COUPLING = "coupling"
"""The word before the dot in recorded names that tell of the coupling, where in others a component's name does."""


Function = Callable[..., object]
"""A Python function as a component: inputs are its parameters, outputs what it returns."""


class Port(str):
    """A variable of a component, by its address ``component.variable``.

    It is the text of the address, and compares, orders and serves as a key like it, so that whoever asks a system or a
    record for a variable may write a string. What is inside holds ports, whose parts need not be told apart again.

    Parameters
    ----------
    component, variable : str
        Names; that of a component has no dot.
    """

    __slots__ = ("component", "variable")

    component: str
    variable: str

    def __new__(cls, component: str, variable: str) -> Port:
        """Join a component and a variable."""
        port = super().__new__(cls, f"{component}.{variable}")
        object.__setattr__(port, "component", component)
        object.__setattr__(port, "variable", variable)
        return port

    @classmethod
    def parse(cls, address: str) -> Port:
        """Split ``component.variable`` at its first dot; a port stays as it is.

        Raises
        ------
        SystemDefinitionError
            If there is no dot, or nothing on one side of it.
        """
        if isinstance(address, cls):
            return address
        component, _, variable = address.partition(".")
        if not component or not variable:
            raise SystemDefinitionError(f"'{address}': expected the form component.variable")
        return cls(component, variable)

    def __reduce__(self) -> tuple[type[Port], tuple[str, str]]:
        """Return what a copy is made from."""
        return Port, (self.component, self.variable)

    def __setattr__(self, name: str, value: object) -> Never:
        """Refuse any change."""
        raise AttributeError(f"{self}: a port cannot be changed")


@dataclass(frozen=True)
class Component:
    """One FMU, or Python function, in a system.

    Parameters
    ----------
    name : str
        Name of the instance, without a dot.
    fmu : str, Path or function
        A name such as ``"DrillstringNeutral"``, looked up among the built FMUs, or the path of an .fmu file; or a
        function, which takes inputs as its parameters and returns outputs, as of `cosim.simulate`.
    parameters : mapping of str to float, int, bool or str
        Start values of parameters and of inputs that nothing drives. An enumeration takes an item's name or number.
    isolate : bool
        Run it in a process of its own, which may crash or hang without harm to the others.
    """

    name: str
    fmu: str | Path | Function
    parameters: Mapping[str, Value] = field(default_factory=dict[str, Value])
    isolate: bool = False

    def __post_init__(self) -> None:
        if not self.name or "." in self.name:
            raise SystemDefinitionError(f"component '{self.name}': expected a name that is not empty and has no dot")
        if self.name == COUPLING:
            raise SystemDefinitionError(f"component '{COUPLING}': records use this name for the coupling itself")
        if not isinstance(cast(object, self.parameters), Mapping):
            raise SystemDefinitionError(
                f"component '{self.name}': parameters are {self.parameters!r}; expected a mapping"
            )
        plain = {name: plain_value(value) for name, value in self.parameters.items()}
        object.__setattr__(self, "parameters", MappingProxyType(plain))

    def __reduce__(self) -> tuple[object, ...]:
        """Return what a copy is made from."""
        return Component, (self.name, self.fmu, dict(self.parameters), self.isolate)


@dataclass(frozen=True, init=False)
class Connection:
    """Let an output drive an input.

    Parameters
    ----------
    source, target : str or Port
        Output and input, each as ``component.variable``.
    unconverted : bool
        Convert no units: pass values on as they are, but for what follows.
    factor, offset : float
        The input gets factor times the value plus offset; both in its unit. For Real variables.
    table : mapping, optional
        What the input gets for what the output gives; what is not listed stays as it is. For Boolean, Integer and
        Enumeration variables, whose items may be given by name.

    Raises
    ------
    SystemDefinitionError
        If an end is not written so, or factor, offset or table make no sense.
    """

    source: Port
    target: Port
    unconverted: bool
    factor: float
    offset: float
    table: tuple[tuple[Value, Value], ...]

    def __init__(
        self,
        source: str,
        target: str,
        *,
        unconverted: bool = False,
        factor: float = 1.0,
        offset: float = 0.0,
        table: Mapping[Any, Value] | None = None,
    ) -> None:
        object.__setattr__(self, "source", Port.parse(source))
        object.__setattr__(self, "target", Port.parse(target))
        object.__setattr__(self, "unconverted", unconverted)
        label = f"connection {source} -> {target}"
        for name, number in (("factor", factor), ("offset", offset)):
            plain = plain_value(number)
            if isinstance(plain, bool | str) or not math.isfinite(plain):
                raise SystemDefinitionError(f"{label}: {name} is {number!r}; expected a finite number")
            object.__setattr__(self, name, float(plain))
        pairs = tuple((plain_value(given), plain_value(taken)) for given, taken in (table or {}).items())
        object.__setattr__(self, "table", pairs)
        if pairs and (self.factor, self.offset) != (1.0, 0.0):
            raise SystemDefinitionError(f"{label} has a table, and a factor or offset as well; expected one of them")


@dataclass(frozen=True, init=False)
class PowerBond:
    """Power that a component takes in: an input and an output of it, of which the product is a power.

    The input is driven by a connection. If the output in turn drives the component that the input comes from, the two
    connections exchange the power; if not, that component is taken to give it at the output's own value.

    Parameters
    ----------
    input, output : str or Port
        Of one component, each as ``component.variable``.

    Raises
    ------
    SystemDefinitionError
        If one is not written so, or they are of two components.
    """

    input: Port
    output: Port

    def __init__(self, input: str, output: str) -> None:  # noqa: A002  named as its fields are
        object.__setattr__(self, "input", Port.parse(input))
        object.__setattr__(self, "output", Port.parse(output))
        first, second = self.input.component, self.output.component
        if first != second:
            raise SystemDefinitionError(
                f"power bond {self.input}, {self.output}: {second} is another component; expected an output of {first}"
            )


_NO_INPUTS: Mapping[str, Signal | float] = MappingProxyType({})


@dataclass(frozen=True, init=False)
class System:
    """Components, the connections between them, and the signals that drive the inputs left over, and parameters.

    Parameters
    ----------
    components : tuple of Component
        In the order of the record; where nothing else decides, they are stepped in it too.
    connections : tuple of Connection
        Each input is driven at most once.
    inputs : mapping of str to Signal or number
        Signals, or constants, by the address ``component.variable`` of the input, or tunable parameter, they drive.
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
    connections: tuple[Connection, ...]
    inputs: Mapping[Port, Signal]
    guards: tuple[Port, ...] | None
    power_bonds: tuple[PowerBond, ...] | None

    def __init__(
        self,
        components: tuple[Component, ...],
        connections: tuple[Connection, ...] = (),
        inputs: Mapping[str, Signal | float] | Mapping[Port, Signal | float] = _NO_INPUTS,
        guards: tuple[str, ...] | None = None,
        power_bonds: tuple[PowerBond, ...] | None = None,
    ) -> None:
        for connection in connections:
            if not isinstance(cast(object, connection), Connection):
                raise SystemDefinitionError(
                    f"connections hold {connection!r}; expected Connection(source, target), each component.variable"
                )
        signals = MappingProxyType({Port.parse(name): _signal(name, given) for name, given in inputs.items()})
        object.__setattr__(self, "components", components)
        object.__setattr__(self, "connections", connections)
        object.__setattr__(self, "inputs", signals)
        object.__setattr__(self, "guards", None if guards is None else tuple(map(Port.parse, guards)))
        object.__setattr__(self, "power_bonds", power_bonds)
        self._refuse_unknown_components()
        self._refuse_double_drives()

    def __reduce__(self) -> tuple[object, ...]:
        """Return what a copy is made from."""
        return System, (self.components, self.connections, dict(self.inputs), self.guards, self.power_bonds)

    def component_of(self, name: str) -> Component:
        """Return the component that ``component.variable`` belongs to, or refuse the name."""
        port = Port.parse(name)
        for component in self.components:
            if component.name == port.component:
                return component
        known = [component.name for component in self.components]
        hint = suggestion(port.component, known)
        raise SystemDefinitionError(f"{name}: there is no component '{port.component}'{hint}")

    def with_values(self, values: Mapping[str, Value | Signal] | Mapping[Port, Value | Signal]) -> System:
        """Return the system with parameters, or inputs that no connection drives, set to other values.

        Parameters
        ----------
        values : mapping of str to float, int, bool, str or Signal
            By ``component.variable``. A value for an input replaces its signal by a constant; a signal takes the place
            of a signal or of a parameter's value.
        """
        inputs = dict(self.inputs)
        parameters = {component.name: dict(component.parameters) for component in self.components}
        for port, value in ((Port.parse(name), plain_value(value)) for name, value in values.items()):
            component = self.component_of(port).name
            if _is_signal(value):
                inputs[port] = value
                parameters[component].pop(port.variable, None)
            elif port in inputs:
                inputs[port] = Constant(value)
            else:
                parameters[component][port.variable] = value
        components = tuple(replace(component, parameters=parameters[component.name]) for component in self.components)
        return replace(self, components=components, inputs=inputs)

    def _refuse_unknown_components(self) -> None:
        """Refuse a system without components, names that are not unique, and addresses of components not in it."""
        names = [component.name for component in self.components]
        if not names:
            raise SystemDefinitionError("the system has no component")
        for name in names:
            if names.count(name) > 1:
                raise SystemDefinitionError(f"component '{name}' is declared {names.count(name)} times; expected once")
        for connection in self.connections:
            self.component_of(connection.source)
            self.component_of(connection.target)
        for port in (*self.inputs, *(self.guards or ()), *(bond.input for bond in self.power_bonds or ())):
            self.component_of(port)

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


def _is_signal(value: object) -> bool:
    """Tell whether something is a signal, of whatever class."""
    return hasattr(value, "breakpoints")


def _signal(name: str, given: object) -> Signal:
    """Take a signal as it is, and a number or Boolean as a constant."""
    value = plain_value(given)
    if isinstance(value, bool | int | float):
        return Constant(value)
    if not _is_signal(value):
        raise SystemDefinitionError(f"{name} is {given!r}; expected a number, true, false or a signal")
    return value
