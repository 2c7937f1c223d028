"""Slaves made from a lambda, to test the master without FMUs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.linalg import expm

from cosim.errors import SlaveError
from cosim.recording.record import BASE_TYPES, Block, initial_value
from cosim.system.description import Description, Unit, Variable
from cosim.system.signals import Value

RAD_PER_S = Unit("rad/s", (0, 0, -1, 0, 0, 0, 0, 1))

Compute = Callable[..., Sequence[float]]


def describe(
    inputs: Mapping[str, float] | None = None,
    outputs: Sequence[str] = (),
    *,
    units: Mapping[str, Unit] | None = None,
    can_vary_step: bool = True,
    can_interpolate_inputs: bool = False,
    can_save_state: bool = True,
    output_derivative_order: int = 0,
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
        "Fake",
        "fake",
        "guid",
        (*variables, *extra),
        can_vary_step=can_vary_step,
        can_interpolate_inputs=can_interpolate_inputs,
        can_save_state=can_save_state,
        output_derivative_order=output_derivative_order,
        feedthrough={name: frozenset(needs) for name, needs in (feedthrough or {}).items()},
    )


class FakeSlave:
    """Outputs are `compute(t, *inputs)`, evaluated at the end of each step, and on reading during initialisation.

    An input that comes with a slope has its value at the end of the step there. `calls` records every call of the
    master, in order.
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
        self.slopes: list[float] = []
        self.start_values: dict[str, Value] = {}
        self.saved: dict[int, tuple[float, dict[str, float], Sequence[float], object]] = {}
        self.outputs: Sequence[float] = ()

    def setup(self, block: Block, start_values: Mapping[Variable, Value], start_time: float, stop_time: float) -> None:
        self.calls.append((self.name, "setup"))
        self.block, self.time = block, start_time
        self.start_values = {variable.name: value for variable, value in start_values.items()}
        inputs = self.description.with_causality("input")
        self.values = {v.name: float(self.start_values.get(v.name, initial_value(v, {}))) for v in inputs}
        self.rates = dict.fromkeys(self.values, 0.0)
        self.initializing = False

    def enter_initialization(self) -> None:
        self.calls.append((self.name, "enter"))
        self.initializing = True

    def exit_initialization(self) -> None:
        self.calls.append((self.name, "exit"))
        self.initializing = False

    def write(self, row: int) -> None:
        self.calls.append((self.name, "write"))
        for section in self.block.inputs.values():
            for column, variable in enumerate(section.variables[: section.driven]):
                self.values[variable.name] = float(section.values[row, column])
        slopes = self.block.slopes
        if slopes is not None and row:
            rates = dict(zip(slopes.references.tolist(), slopes.values[row].tolist(), strict=True))
            self.rates = {name: rates.get(self.description.by_name[name].reference, 0.0) for name in self.values}
            self.slopes.append(next(iter(rates.values())))

    def step(self, time: float, size: float) -> None:
        self.calls.append((self.name, "step"))
        if self.fail_at is not None and time >= self.fail_at:
            raise SlaveError(self.name, time, "fmi2DoStep", "fmi2Discard", "no more")
        self.steps.append((time, size))
        self.time = time + size
        self.outputs = self.advance(size)

    def advance(self, size: float) -> Sequence[float]:
        return self.compute(self.time, *(self.values[name] + size * self.rates[name] for name in self.values))

    def read(self, row: int) -> None:
        self.calls.append((self.name, "read"))
        if self.initializing:
            self.outputs = self.compute(self.time, *self.values.values())
        sections = [self.block.outputs[kind] for kind in BASE_TYPES]
        outputs = dict(zip((v.name for v in self.description.with_causality("output")), self.outputs, strict=True))
        for section in sections:
            section.values[row] = [outputs[variable.name] for variable in section.variables]
        if self.block.output_slopes is not None and not self.initializing:
            self.block.output_slopes.values[row] = self.derivatives()

    def derivatives(self) -> Sequence[float]:
        """Return output derivatives, by differences just after the present."""
        after = self.compute(self.time + 1e-6, *self.values.values())
        return [(b - a) / 1e-6 for a, b in zip(self.outputs, after, strict=True)]

    def save(self, slot: int) -> None:
        assert self.description.can_save_state
        self.calls.append((self.name, f"save {slot}"))
        self.saved[slot] = self.time, dict(self.values), self.outputs, self.state()

    def restore(self, slot: int) -> None:
        self.calls.append((self.name, f"restore {slot}"))
        self.time, values, self.outputs, state = self.saved[slot]
        self.values = dict(values)
        self.rates = dict.fromkeys(self.values, 0.0)
        self.set_state(state)

    def state(self) -> object:
        """Return what else there is of a state."""
        return None

    def set_state(self, state: object) -> None:
        """Return to it."""

    def terminate(self) -> None:
        self.calls.append((self.name, "terminate"))


class LinearSlave(FakeSlave):
    """x' = A x + B u, y = C x + D u with inputs on straight lines, solved exactly by the matrix exponential.

    Inputs are ``u0``, ``u1``, ..., outputs ``y0``, ``y1``, ... An input feeds through to an output where D says so.
    """

    def __init__(
        self,
        a: Sequence[Sequence[float]],
        b: Sequence[Sequence[float]],
        c: Sequence[Sequence[float]],
        d: Sequence[Sequence[float]] | None = None,
        start: Sequence[float] = (),
        **options: Any,
    ) -> None:
        self.a, self.b, self.c = (np.array(matrix, dtype=float) for matrix in (a, b, c))
        self.d = np.zeros((self.c.shape[0], self.b.shape[1])) if d is None else np.array(d, dtype=float)
        self.x = np.array(start or [0.0] * self.a.shape[0])
        self.flows: dict[float, np.ndarray] = {}
        inputs = {f"u{i}": 0.0 for i in range(self.b.shape[1])}
        outputs = [f"y{i}" for i in range(self.c.shape[0])]
        through = {f"y{i}": [f"u{j}" for j in np.flatnonzero(row)] for i, row in enumerate(self.d)}
        description = describe(inputs, outputs, feedthrough=through, **options)
        super().__init__(self._outputs, description=description)

    def _outputs(self, time: float, *inputs: float) -> Sequence[float]:
        del time
        return (self.c @ self.x + self.d @ np.array(inputs)).tolist()

    def advance(self, size: float) -> Sequence[float]:
        if size not in self.flows:
            n, m = self.b.shape
            blocks = np.zeros((n + 2 * m, n + 2 * m))
            blocks[:n, :n], blocks[:n, n : n + m], blocks[n : n + m, n + m :] = self.a, self.b, np.eye(m)
            self.flows[size] = expm(size * blocks)[:n]
        self.x = self.flows[size] @ np.array([*self.x, *self.values.values(), *self.rates.values()])
        return super().advance(size)

    def state(self) -> object:
        return self.x.copy()

    def set_state(self, state: object) -> None:
        self.x = np.array(state)
