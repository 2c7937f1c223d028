"""Reference experiments of WeightOnBitLaw."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal

from tests.reference.experiment import Experiment, Tolerance
from tests.reference.sweep import STEP, Row, Sweep, spread


def weight(row: Row) -> Mapping[str, Decimal]:
    """Eq. (22) of the paper with its limit, and the default parameters."""
    return {"WOB": min(5000 * abs(row["bit_speed"]) + 97347, Decimal(300000))}


_WEIGHT = Sweep(weight, {"bit_speed": (0.0, -0.0, 40.53, 40.54, -40.54, *spread(35, -60.0, 60.0, 0.618))})

EXPERIMENTS = (
    Experiment(
        "sweep", "Bit speeds of both signs, up to where the weight is limited",
        _WEIGHT.stop_time, STEP, 1, _WEIGHT.answer,
        {"WOB": Tolerance("rounding: two operations on at most 3e5 N, in doubles of 1.1e-16", 1e-10)},
        inputs=_WEIGHT.inputs,
    ),
)  # fmt: skip
