"""LowPassLaw: the rotation asked for, smoothed by a filter of first order, as the speed of the drive."""

from __future__ import annotations

from typing import Any

from ...page.prose import paragraphs, phrases
from ...python.law import Law
from ...rows import drive_terminal, flag_row, input_row, output_row, parameter_row, references_terminal
from ...schema import Model

MODEL = Model(
    name="LowPassLaw",
    description="Drive speed that follows the rotation asked for through a filter of first order",
    variables=(
        input_row("speed_ref", "rad/s", 0.0, "Rotation asked for", "Filter", low=-1e4, high=1e4),
        output_row("Omega", "rad/s", "Angular velocity of the drive", "Filter", initially=("speed_ref", "Omega_max")),
        flag_row("limit_active", "Omega is held at its limit", "Filter", (), ("speed_ref", "Omega_max")),
        parameter_row("time_constant", "s", 2.0, 1e-3, 1e6, "Time constant", "Filter", "tunable"),
        parameter_row("Omega_max", "rad/s", 40.0, 1e-3, 1e4, "Limit of Omega in both directions", "Filter", "tunable"),
    ),
    equations=(
        (
            "Filter",
            paragraphs(r"""
The filter's state $x$ begins at the rotation asked for and follows it by the implicit rule of Euler,

$$ x(t + h) = x(t) + \frac{h}{\tau + h} (r(t + h) - x(t)), $$ Filter

with the time constant $\tau$ (`time_constant`); `Omega` is $x$ within `Omega_max`.
"""),
        ),
    ),
    use=phrases("Connect `speed_ref` from DrillingProgram and `Omega` to the string."),
    limits=phrases("The communication step is the sample time of the filter."),
    terminals=(drive_terminal("Omega"), references_terminal("speed_ref")),
)


class LowPassLaw(Law):
    """Omega from the rotation asked for."""

    model = MODEL

    def begin(self, values: list[Any]) -> tuple[float, ...]:
        """Begin at the rotation asked for."""
        return (values[self.at["speed_ref"]],)

    def advance(self, values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Approach the rotation asked for."""
        (smoothed,) = self.memory
        share = elapsed / (values[self.at["time_constant"]] + elapsed)
        return (smoothed + share * (values[self.at["speed_ref"]] - smoothed),)

    def answer(self, memory: tuple[float, ...], values: list[Any]) -> None:
        """Answer within the limit."""
        limit = values[self.at["Omega_max"]]
        values[self.at["limit_active"]] = abs(memory[0]) > limit
        values[self.at["Omega"]] = limit if memory[0] > limit else -limit if memory[0] < -limit else memory[0]

    def tell_changes(self, before: list[Any], values: list[Any], time: float) -> None:
        """Say when the limit begins and ends to hold."""
        at = self.at["limit_active"]
        if values[at] != before[at]:
            self.event(time, "Omega is held at its limit" if values[at] else "Omega is off its limit again")
