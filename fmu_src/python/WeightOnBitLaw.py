"""The weight on bit of eq. (22) as a pythonfmu slave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fmu_src.interface import WEIGHT_ON_BIT_LAW
from fmu_src.python.slave import TableSlave
from models.laws import WeightOnBitLaw as Law

_AT = {variable.name: index for index, variable in enumerate(WEIGHT_ON_BIT_LAW.variables)}


class WeightOnBitLaw(TableSlave):
    """WOB from the bit speed."""

    model = WEIGHT_ON_BIT_LAW

    def check(self, values: Sequence[Any]) -> str | None:
        """Return what is wrong between the limits."""
        if values[_AT["WOB_max"]] < values[_AT["WOB_0"]]:
            return f"WOB_max is {values[_AT['WOB_max']]}; expected at least WOB_0 = {values[_AT['WOB_0']]}"
        return None

    def start(self, values: list[Any], time: float) -> None:
        """Answer the input as it is."""
        self._answer(values)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Answer the input as it is."""
        self._answer(values)

    def _answer(self, values: list[Any]) -> None:
        law = Law(values[_AT["K_w"]], values[_AT["WOB_0"]], values[_AT["WOB_max"]])
        values[_AT["WOB"]] = law.weight(values[_AT["bit_speed"]])

    def state(self) -> object:
        """Return None: the law has no memory."""
        return None

    def restore(self, state: Any) -> None:
        """Take nothing over."""
