"""Slaves made from a lambda, to test the master without FMUs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from cosim.description import Description, Unit, Variable
from cosim.errors import SlaveError
from cosim.record import Block
from cosim.signals import Value

RAD_PER_S = Unit("rad/s", (0, 0, -1, 0, 0, 0, 0, 1))

Compute = Callable[..., Sequence[float]]


def describe(
    inputs: Mapping[str, float] | None = None,
    outputs: Sequence[str] = (),
    *,
    units: Mapping[str, Unit] | None = None,
    can_vary_step: bool = True,
    can_interpolate_inputs: bool = False,
    extra: Sequence[Variable] = (),
    feedthrough: Mapping[str, Sequence[str]] | None = None,
) -> Description:
    """Describe an FMU with Real inputs (and their start values) and Real outputs, which by default feed through all."""
    units = units or {}
    names = [(name, "input", str(start)) for name, start in (inputs or {}).items()]
    names += [(name, "output", None) for name in outputs]
    variables = tuple(
        Variable(name, index, "Real", causality, unit=units.get(name), start=start)
        for index, (name, causality, start) in enumerate(names)
    )
    return Description(
        "Fake", "fake", "guid", (*variables, *extra), can_vary_step=can_vary_step,
        can_interpolate_inputs=can_interpolate_inputs,
        feedthrough={name: frozenset(needs) for name, needs in (feedthrough or {}).items()},
    )  # fmt: skip


class FakeSlave:
    """Outputs are `compute(t, *inputs)`, evaluated at the end of each step, and on reading during initialisation.

    `calls` records every call of the master, in order.
    """

    def __init__(
        self,
        compute: Compute,
        inputs: Mapping[str, float] | None = None,
        outputs: Sequence[str] = ("y",),
        *,
        description: Description | None = None,
        fail_at: float | None = None,
        journal: list[tuple[str, str]] | None = None,
        name: str = "fake",
    ) -> None:
        self.description = description or describe(inputs, outputs)
        self.compute = compute
        self.fail_at = fail_at
        self.name = name
        self.calls = journal if journal is not None else []
        self.steps: list[tuple[float, float]] = []
        self.written: list[dict[str, float]] = []
        self.slopes: list[float] = []
        self.start_values: dict[str, Value] = {}

    def setup(self, block: Block, start_values: Mapping[Variable, Value], start_time: float, stop_time: float) -> None:
        self.calls.append((self.name, "setup"))
        self.block, self.time = block, start_time
        self.start_values = {variable.name: value for variable, value in start_values.items()}
        inputs = self.description.with_causality("input")
        self.values = {v.name: float(self.start_values.get(v.name, v.start or 0.0)) for v in inputs}
        self.initializing = False

    def enter_initialization(self) -> None:
        self.calls.append((self.name, "enter"))
        self.initializing = True

    def exit_initialization(self) -> None:
        self.calls.append((self.name, "exit"))
        self.initializing = False

    def write(self, row: int) -> None:
        section = self.block.inputs["Real"]
        self.calls.append((self.name, "write"))
        for column, variable in enumerate(section.variables[: section.driven]):
            self.values[variable.name] = float(section.values[row, column])
        self.written.append(dict(self.values))
        if self.block.slopes is not None and row:
            self.slopes.append(float(self.block.slopes.values[row, 0]))

    def step(self, time: float, size: float) -> None:
        self.calls.append((self.name, "step"))
        if self.fail_at is not None and time >= self.fail_at:
            raise SlaveError(self.name, time, "fmi2DoStep", "fmi2Discard", "no more")
        self.steps.append((time, size))
        self.time = time + size
        self.outputs = self.compute(self.time, *self.values.values())

    def read(self, row: int) -> None:
        self.calls.append((self.name, "read"))
        if self.initializing:
            self.outputs = self.compute(self.time, *self.values.values())
        self.block.outputs["Real"].values[row] = self.outputs

    def terminate(self) -> None:
        self.calls.append((self.name, "terminate"))
