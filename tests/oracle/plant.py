"""The problem that is solved: the constants of the string and the bit, and the programs that drive them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class OracleParameters:
    """Constants of string, bit and history, in SI units, by the paper's symbols and with the paper's values.

    `I_B` is the exception: the paper leaves it out. `initial_speed` [rad/s] and `initial_torque` [N m] are the uniform
    rotation and the uniform transmitted torque before t = 0.
    """

    G: float = 79.3e9
    J: float = 1.19e-5
    I: float = 0.095  # noqa: E741 (the paper's symbol)
    L: float = 1172.0
    I_B: float = 89.0
    c_a: float = 2000.0
    c_b: float = 0.03
    R_b: float = 0.155575
    mu_cb: float = 0.5
    mu_sb: float = 0.8
    gamma_b: float = 0.9
    v_f: float = 1.0
    initial_speed: float = 0.0
    initial_torque: float = 0.0

    @property
    def impedance(self) -> float:
        """Wave impedance of the string, sqrt(I G J) [N m s/rad]."""
        return math.sqrt(self.I * self.G * self.J)

    @property
    def travel_time(self) -> float:
        """Time a wave takes from one end to the other, L sqrt(I / (G J)) [s]."""
        return self.L * math.sqrt(self.I / (self.G * self.J))

    @property
    def reflection(self) -> float:
        """Top reflection (c_a - Z) / (c_a + Z); a wave U comes back as minus this times U."""
        return (self.c_a - self.impedance) / (self.c_a + self.impedance)

    @property
    def transmission(self) -> float:
        """Share c_a / (c_a + Z) of the drive speed that enters the string."""
        return self.c_a / (self.c_a + self.impedance)

    @property
    def initial_down(self) -> float:
        """Down-going wave of the uniform history, v0/2 + tau0/(2 Z) [rad/s]."""
        return self.initial_speed / 2 + self.initial_torque / (2 * self.impedance)

    @property
    def initial_up(self) -> float:
        """Up-going wave of the uniform history, v0/2 - tau0/(2 Z) [rad/s]."""
        return self.initial_speed / 2 - self.initial_torque / (2 * self.impedance)


@dataclass(frozen=True)
class Program:
    """A piecewise linear input: values[i] + slopes[i] (t - times[i]) on [times[i], times[i+1]).

    The first time is 0 and the last segment never ends. Jumps are allowed at every time.

    Raises
    ------
    ValueError
        If the lengths differ or are zero, times[0] is not 0, times do not increase or a number is not finite.
    """

    times: Sequence[float]
    values: Sequence[float]
    slopes: Sequence[float]

    def __post_init__(self) -> None:
        for name in ("times", "values", "slopes"):
            object.__setattr__(self, name, tuple(float(number) for number in getattr(self, name)))
        if not len(self.times) == len(self.values) == len(self.slopes) > 0:
            raise ValueError("a program needs as many times as values and slopes, and at least one")
        if self.times[0] != 0 or any(b <= a for a, b in zip(self.times, self.times[1:], strict=False)):
            raise ValueError(f"program times must increase from 0, got {self.times}")
        if not all(map(math.isfinite, (*self.times, *self.values, *self.slopes))):
            raise ValueError("program numbers must be finite")

    @classmethod
    def held(cls, times: Sequence[float], values: Sequence[float]) -> Program:
        """Steps: each value held from its time until the next."""
        return cls(times, values, [0.0] * len(times))

    @classmethod
    def constant(cls, value: float) -> Program:
        """One value for ever."""
        return cls((0.0,), (value,), (0.0,))

    def line(self, inside: float, start: float) -> tuple[float, float]:
        """Value at `start` and slope of the segment that holds the instant `inside`."""
        index = max(bisect_right(self.times, inside) - 1, 0)
        return self.values[index] + self.slopes[index] * (start - self.times[index]), self.slopes[index]

    def held_after(self, time: float) -> Program:
        """Return the same program up to `time`, and the value it has just before it from then on."""
        kept = [index for index, begin in enumerate(self.times) if begin < time] or [0]
        value = self.values[kept[-1]] + self.slopes[kept[-1]] * (time - self.times[kept[-1]])
        columns = ([column[index] for index in kept] for column in (self.times, self.values, self.slopes))
        times, values, slopes = columns
        if time <= 0:
            return Program.constant(self.values[0])
        return Program([*times, time], [*values, value], [*slopes, 0.0])
