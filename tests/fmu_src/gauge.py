"""A model small enough to test the machinery with: it adds up its input."""

from __future__ import annotations

from typing import Any

from fmu_src.python.slave import TableSlave
from fmu_src.schema import Model, Variable

GAUGE = Model(
    name="Gauge",
    description="Adds up its input",
    variables=(
        Variable("rate", "input", "Rate", unit="rad/s", start=1.0, minimum=0.0, maximum=10.0),
        Variable("total", "output", "Total", unit="rad", initial_dependencies=("offset",)),
        Variable("count", "output", "Steps", "Integer", "discrete"),
        Variable("full", "output", "Total above the limit", "Boolean", "discrete"),
        Variable("offset", "parameter", "Offset", variability="fixed", unit="rad", start=0.5, maximum=100.0),
        Variable("limit", "parameter", "Limit", variability="tunable", unit="rad", start=50.0),
        Variable("mode", "parameter", "Mode", "Enumeration", "fixed", start=1, items=("plain", "fancy")),
        Variable("label", "parameter", 'A "label"', "String", "fixed", start="a?b"),
    ),
    log_categories=(("logEvents", "Events"), ("logStatusDiscard", "Discards")),
)
RATE, TOTAL, COUNT, FULL, OFFSET, LIMIT, MODE, LABEL = range(8)


class Gauge(TableSlave):
    """The slave; its memory is `hidden`, which is no variable."""

    model = GAUGE

    def check(self, values: Any) -> str | None:
        return None if values[OFFSET] <= values[LIMIT] else "offset is above limit"

    def start(self, values: list[Any], time: float) -> None:
        self.hidden = [values[OFFSET], 0]
        self._write(values)

    def step(self, values: list[Any], time: float, end: float) -> None:
        step_size = end - time
        if step_size > 5.0:
            values[TOTAL] = -1.0
            raise ValueError("a step above 5 s cannot be taken (100 %)")
        if values[MODE] == 2 and step_size > 4.0:
            raise KeyboardInterrupt
        self.hidden = [self.hidden[0] + values[RATE] * step_size, self.hidden[1] + 1]
        self._write(values)

    def _write(self, values: list[Any]) -> None:
        values[TOTAL], values[COUNT] = self.hidden[0], self.hidden[1]
        values[FULL] = values[TOTAL] > values[LIMIT]

    def state(self) -> object:
        return {"hidden": list(self.hidden)}

    def restore(self, state: Any) -> None:
        self.hidden = list(state["hidden"])
