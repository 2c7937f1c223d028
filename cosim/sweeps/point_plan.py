"""Hold what a worker needs to run points of a sweep: the system, its FMUs as bytes, and how a point is set."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

from cosim.sweeps.measures import MeasureSet
from cosim.sweeps.series import Rows
from cosim.system.description import Description
from cosim.system.method import Method
from cosim.system.signals import Constant, Value
from cosim.system.structure import Component, System


@dataclass(frozen=True)
class File:
    """An FMU on its way to a worker: its name, its content, and what it says of itself."""

    name: str
    content: bytes
    description: Description


@dataclass(frozen=True)
class PointPlan:
    """Hold what a worker needs to run points of a sweep.

    Attributes
    ----------
    system : System
        With all values but those that vary.
    files : mapping of str to File
        By SHA-256.
    choices : mapping of str to mapping of str to str
        By component and name of an FMU: which file.
    chosen : mapping of str to str
        By component: the name of its FMU where that does not vary.
    names : tuple of str
        What varies, in the order in which values are given.
    start_time, duration, step_size : float
        Of each point, s.
    points_per_run : int
        How many points one run goes on over.
    method : Method
        How the system is stepped.
    measures : MeasureSet
        What is taken from each point.
    series : Rows or None
        What is kept over time of some.
    functions : mapping of str to Description
        Of the components that are Python functions, which go to workers as `pickle` sends them.
    """

    system: System
    files: Mapping[str, File]
    choices: Mapping[str, Mapping[str, str]]
    chosen: Mapping[str, str]
    names: tuple[str, ...]
    start_time: float
    duration: float
    step_size: float
    points_per_run: int
    method: Method
    measures: MeasureSet
    series: Rows | None = None
    functions: Mapping[str, Description] = field(default_factory=dict[str, Description])

    def descriptions(self, chosen: Mapping[str, str]) -> dict[str, Description]:
        """Return the descriptions of the components for a choice of FMUs."""
        known = {name: self.files[self.choices[name][fmu]].description for name, fmu in chosen.items()}
        known |= self.functions
        return {part.name: known[part.name] for part in self.system.components}

    def system_of(self, chosen: Mapping[str, str]) -> System:
        """Return the system for a choice of FMUs; parameters that an FMU in another's place lacks are left out."""
        if chosen == self.chosen:
            return self.system
        known = self.descriptions(chosen)
        return replace(
            self.system, components=tuple(_fitting(part, known[part.name]) for part in self.system.components)
        )

    def split(self, values: Mapping[str, Value]) -> tuple[dict[str, str], dict[str, Value]]:
        """Tell the FMUs that are chosen from the values that are set."""
        fmus = {name: str(value) for name, value in values.items() if name in self.choices}
        return {**self.chosen, **fmus}, {name: value for name, value in values.items() if name not in self.choices}

    def known_descriptions(self) -> Iterator[dict[str, Description]]:
        """Go through the descriptions of the components for each choice of FMUs."""
        names = list(self.choices)
        for values in product(*self.choices.values()):
            yield self.descriptions(dict(zip(names, values, strict=True)))

    @property
    def takes_long_steps(self) -> bool:
        """Tell whether a point is run in a long step up to its window: nothing is coupled, and no input moves."""
        return (
            self.measures.sampling is not None
            and self.method.tolerance is None
            and not self.method.implicit
            and not self.system.connections
            and not self.functions
            and all(isinstance(signal, Constant) for signal in self.system.inputs.values())
            and all(file.description.can_vary_step for file in self.files.values())
        )


def _fitting(part: Component, description: Description) -> Component:
    """Return a component with those of its parameters that an FMU has."""
    kept = {name: value for name, value in part.parameters.items() if name in description.by_name}
    return replace(part, parameters=kept)
