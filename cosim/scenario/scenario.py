"""A scenario: a system, how long and how to run it, and the variants to compare."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import cast

from cosim.errors import ScenarioError, suggestion
from cosim.system.field_units import seconds
from cosim.system.method import Method
from cosim.system.signals import Signal, Value, plain_value
from cosim.system.structure import System

_SAFE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+=-]*")


@dataclass(frozen=True)
class Variant:
    """A scenario with other values.

    Parameters
    ----------
    name : str
        Serves as the name of a folder: letters, digits and ``_ . + = -``.
    values : mapping of str to value or Signal
        Parameters and input values, or signals, by ``component.variable``.
    """

    name: str
    values: Mapping[str, Value | Signal] = field(default_factory=dict[str, Value | Signal])

    def __post_init__(self) -> None:
        if not isinstance(cast(object, self.values), Mapping):
            raise ScenarioError(f"variant '{self.name}': values are {self.values!r}; expected a mapping")
        if not _SAFE_NAME.fullmatch(self.name):
            raise ScenarioError(f"variant '{self.name}': expected a name of letters, digits and _ . + = - only")
        plain = {name: plain_value(value) for name, value in self.values.items()}
        object.__setattr__(self, "values", MappingProxyType(plain))

    def __reduce__(self) -> tuple[object, ...]:
        """Return what a copy is made from."""
        return Variant, (self.name, dict(self.values))


@dataclass(frozen=True)
class Scenario:
    """Describe a run for `cosim.simulate`.

    Parameters
    ----------
    name : str
        Short name; also of the default output folder.
    system : System
        What is coupled with what.
    stop_time, step_size, start_time : float
        In s.
    method : Method
        Algorithm of the master and its settings.
    title, description : str
        For people.
    variants : tuple of Variant
        Alternatives; the first is the default. None means the system as it is.
    signals : tuple of str
        What the figure shows, one panel each; empty means what suits the system.
    folder : Path, optional
        Folder that relative paths of FMUs start from.
    """

    name: str
    system: System
    stop_time: float
    step_size: float
    start_time: float = 0.0
    method: Method = field(default_factory=Method)
    title: str = ""
    description: str = ""
    variants: tuple[Variant, ...] = ()
    signals: tuple[str, ...] = ()
    folder: Path | None = None

    def __post_init__(self) -> None:
        for name in ("stop_time", "step_size", "start_time"):
            object.__setattr__(self, name, seconds(getattr(self, name), f"{self.name}: {name}"))
        names = [variant.name for variant in self.variants]
        if len(set(names)) < len(names):
            raise ScenarioError(f"{self.name}: two variants have the same name; expected each name once")
        for variant in self.variants:
            self.system.with_values(variant.values)
        for signal in self.signals:
            self.system.component_of(signal)

    def variant(self, name: str | None = None) -> Variant | None:
        """Return a variant by name, by default the first; None if there are none and none is asked for.

        Raises
        ------
        ScenarioError
            If there is no variant of that name.
        """
        if name is None:
            return self.variants[0] if self.variants else None
        for variant in self.variants:
            if variant.name == name:
                return variant
        hint = suggestion(str(name), [variant.name for variant in self.variants])
        raise ScenarioError(f"{self.name}: there is no variant '{name}'{hint}")

    def system_of(self, variant: Variant | None, overrides: Mapping[str, Value] | None = None) -> System:
        """Return the system with the values of a variant, and on top of these others by ``component.variable``.

        Raises
        ------
        InputError
            If something that a value is given for does not exist.
        """
        return self.system.with_values(variant.values if variant else {}).with_values(overrides or {})
