"""A drive that meets the string as a damper, spring and mass do, in matrices: docs/cures.md, equations 1 to 7."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import mpmath

from tests.reference.stepwise import Law, Row

STRING = {"G": 79.3e9, "J": 1.19e-5, "I": 0.095, "L": 1172.0, "I_B": 89.0, "c_a": 2000.0}
TIMES = {"filter_time": 0.04, "slip_time": 5.0, "handover_time": 1.0, "Omega_max": 40.0}

Gains = Callable[[Any, Any], tuple[Any, Any, Any]]
"""From impedance and stick-slip frequency to damping, stiffness and inertia."""


def frequency(p: Mapping[str, Any], impedance: Any) -> Any:
    """Return the lowest root of tan(omega Gamma) = Z / (omega I_B)."""
    away = p["L"] * mpmath.sqrt(p["I"] / (p["G"] * p["J"]))
    lag = mpmath.findroot(lambda x: mpmath.cot(x) - x * p["I_B"] / (impedance * away), (0.01, 1.5), solver="anderson")
    return lag / away


def law_of(parameters: Mapping[str, float], gains: Gains, compensated: bool = False) -> Law:
    """Return the law with parameters other than their start values."""
    return lambda: _VirtualDrive(parameters, gains, compensated).functions()


class _VirtualDrive:
    def __init__(self, parameters: Mapping[str, float], gains: Gains, compensated: bool) -> None:
        given = STRING | TIMES | dict(parameters)
        self.p = {name: mpmath.mpf(value) for name, value in given.items()}
        self.z = mpmath.sqrt(self.p["I"] * self.p["G"] * self.p["J"])
        self.gains = gains(self.z, frequency(self.p, self.z))
        self.compensated = compensated

    def functions(self) -> tuple[Callable[[Row], Row], Callable[[Row, Any], Row]]:
        return self.begin, self.go_on

    def begin(self, row: Row) -> Row:
        self.wave, self.torque = self._wave(row), row["top_torque"]
        self.lag, self.turned = mpmath.mpf(0), self._pull(row) / self.gains[1]
        self.rest = row["speed_ref"] - self._asked(row)
        return self._answer(row)

    def go_on(self, row: Row, step: Any) -> Row:
        early = self._pull(row)
        for name, time, target in (
            ("wave", "filter_time", self._wave(row)),
            ("torque", "slip_time", row["top_torque"]),
        ):
            share = mpmath.exp(-step / self.p[time])
            setattr(self, name, target + (getattr(self, name) - target) * share)
        pull = (early + self._pull(row)) / 2
        P, K, J_v = self.gains
        # M (x1 - x0) / h = A (x1 + x0) / 2 + b for x = (u, q)
        mass = mpmath.matrix([[J_v, 0], [0, 1]])
        flow = mpmath.matrix([[-(P + self.z), -K], [1, 0]])
        before = mpmath.matrix([self.lag, self.turned])
        if J_v == 0:  # u is no state: q' = (pull - K q) / (P + Z)
            rate = K / (P + self.z)
            self.turned = (self.turned * (2 / step - rate) + 2 * pull / (P + self.z)) / (2 / step + rate)
        else:
            right = (mass / step + flow / 2) * before + mpmath.matrix([pull, 0])
            self.lag, self.turned = mpmath.lu_solve(mass / step - flow / 2, right)
        self.rest = self.rest * mpmath.exp(-step / self.p["handover_time"])
        return self._answer(row)

    def _wave(self, row: Row) -> Any:
        return row["top_speed"] / 2 - row["top_torque"] / (2 * self.z)

    def _meant(self, row: Row) -> Any:
        return row["speed_ref"] - (0 if self.compensated else self.torque / self.p["c_a"])

    def _pull(self, row: Row) -> Any:
        return self.z * self._meant(row) - 2 * self.z * self.wave

    def _asked(self, row: Row) -> Any:
        P, K, J_v = self.gains
        lag = self.lag if J_v else (self._pull(row) - K * self.turned) / (P + self.z)
        # the torque of a wave sent down, and the speed at which the slip passes it on
        down = self._meant(row) - lag - self.wave
        return down + self.wave + self.z * (down - self.wave) / self.p["c_a"]

    def _answer(self, row: Row) -> Row:
        omega, limit = self._asked(row) + self.rest, self.p["Omega_max"]
        return {"Omega": min(max(omega, -limit), limit), "limit_active": bool(abs(omega) > limit)}
