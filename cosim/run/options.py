"""Carry the options of a run as one object from the command line, or a call, to the master."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import asdict, dataclass, field, replace
from typing import Any, TypedDict, cast

from cosim.errors import InputError
from cosim.fmi2.isolation import Limits
from cosim.scenario.scenario import Scenario
from cosim.system.compatibility import Written
from cosim.system.field_units import seconds
from cosim.system.method import Method
from cosim.system.signals import Value, plain_value
from cosim.system.structure import Connection, Function

INTERVAL = 30.0
"""Seconds between checkpoints."""


class OptionKeywords(TypedDict, total=False):
    """Keywords of `cosim.simulate` and `cosim.stream`: the fields of `RunOptions`."""

    packaging: str
    algorithm: str | None
    tolerance: float | None
    on_failure: str | None
    step_size: float | None
    stop_time: float | None
    overrides: Mapping[str, Value] | None
    variant: str | None
    isolate: bool | Collection[str]
    limits: Limits | None
    components: Mapping[str, Function] | None
    connections: Collection[Connection]


_WRITTEN = "written"


@dataclass(frozen=True)
class WrittenOptions:
    """Hold those options of a run that can be written down, and read back to go on with it: see `RunOptions`."""

    packaging: str = "native"
    algorithm: str | None = None
    tolerance: float | None = None
    on_failure: str | None = None
    step_size: float | None = None
    stop_time: float | None = None
    overrides: Mapping[str, Value] | None = None
    variant: str | None = None
    isolate: bool | str | Sequence[str] | Set[str] = False
    limits: Limits | None = None


@dataclass(frozen=True)
class RunOptions(WrittenOptions):
    """Options of a run; None leaves the scenario's own.

    Parameters
    ----------
    packaging : str
        ``"native"`` or ``"python"``: which build of the FMUs that are given by name.
    algorithm : str, optional
        ``"jacobi"``, ``"gauss-seidel"`` or ``"implicit"``.
    tolerance : float, optional
        Of the error of a step; the step size varies then, and `step_size` is the greatest.
    on_failure : str, optional
        ``"fail"``, ``"halve"`` or ``"explicit"``, where a loop has no solution.
    step_size, stop_time : float, optional
        In s.
    overrides : mapping of str to value, optional
        Parameters and input values by ``component.variable``, on top of the variant's.
    variant : str, optional
        Name of the variant; by default the first.
    isolate : bool or collection of str
        Run all components, or those of these names, in processes of their own, as well as those that the scenario
        isolates.
    limits : Limits, optional
        Of time and memory, for the isolated components.
    components : mapping of str to function, optional
        Python functions in place of components of these names, or as new ones, which `connections` name.
    connections : collection of Connection
        In addition to the scenario's; each replaces what else drives its target.
    """

    components: Mapping[str, Function] | None = None
    connections: Collection[Connection] = ()

    def __post_init__(self) -> None:
        for name in ("step_size", "stop_time"):
            given = getattr(self, name)
            object.__setattr__(self, name, None if given is None else seconds(given, name))
        object.__setattr__(self, "tolerance", plain_value(self.tolerance))
        if self.overrides is not None and not isinstance(cast(object, self.overrides), Mapping):
            raise InputError(
                f"overrides is {self.overrides!r}; expected a mapping by component.variable, such as "
                '{"plant.WOB": 6e4}'
            )
        if self.overrides is not None:
            plain = {name: plain_value(value) for name, value in self.overrides.items()}
            object.__setattr__(self, "overrides", plain)
        if self.components is not None and not isinstance(cast(object, self.components), Mapping):
            raise InputError(f'components is {self.components!r}; expected a mapping such as {{"law": my_function}}')
        for name, function in (self.components or {}).items():
            if not callable(cast(object, function)):
                raise InputError(f"components: '{name}' is {function!r}; expected a function")
        for connection in self.connections:
            if not isinstance(cast(object, connection), Connection):
                raise InputError(
                    f"connections hold {connection!r}; expected Connection(source, target), each component.variable"
                )

    def method(self, scenario: Scenario) -> Method:
        """Return the scenario's method with the settings given here; raises InputError if they make no sense."""
        settings = {"algorithm": self.algorithm, "tolerance": self.tolerance, "on_failure": self.on_failure}
        return replace(scenario.method, **{name: value for name, value in settings.items() if value is not None})

    def to_json(self) -> dict[str, Any]:
        """Return the options as JSON can hold them; values that are still to be read, as tables."""
        if self.components or self.connections:
            raise InputError("a run with Python functions cannot be written down; expected cosim.stream to resume it")
        overrides = self.overrides and {
            name: {_WRITTEN: str(value)} if isinstance(value, Written) else value
            for name, value in self.overrides.items()
        }
        told = {name: value for name, value in asdict(self).items() if name not in ("components", "connections")}
        return {**told, "overrides": overrides}

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> RunOptions:
        """Read back what `to_json` returned."""
        limits: Mapping[str, float] | None = content["limits"]
        overrides: Mapping[str, Any] | None = content["overrides"] and {
            name: Written(cast(Any, value)[_WRITTEN]) if isinstance(value, dict) else value
            for name, value in content["overrides"].items()
        }
        given: dict[str, Any] = {**content, "limits": Limits(**limits) if limits else None, "overrides": overrides}
        return cls.of(WrittenOptions(**given))

    @classmethod
    def of(cls, written: WrittenOptions) -> RunOptions:
        """Return the options that were written down."""
        told: dict[str, Any] = vars(written)
        return cls(**told)


def chosen(options: RunOptions | None, keywords: OptionKeywords) -> RunOptions:
    """Return options with keywords on top of them."""
    return replace(options or RunOptions(), **keywords)


@dataclass(frozen=True)
class Streaming:
    """Options of writing rows to disk as they come.

    Parameters
    ----------
    strides : mapping of str to int
        By name or pattern of columns: 1 stores all rows, 10 every tenth, 0 none; see `cosim.run.store.decimate`.
    csv : bool
        Write CSV instead of Zarr.
    checkpoint_interval : float
        Seconds between checkpoints.
    """

    strides: Mapping[str, int] = field(default_factory=dict[str, int])
    csv: bool = False
    checkpoint_interval: float = INTERVAL

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON can hold it."""
        return {"every": dict(self.strides), "csv": self.csv, "checkpoint_interval": self.checkpoint_interval}

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Streaming:
        """Read back what `to_json` returned."""
        return cls(content["every"], content["csv"], content["checkpoint_interval"])
