"""Reference experiments of TopAbsorber."""

from __future__ import annotations

from tests.reference.experiment import Experiment, Tolerance
from tests.reference.stepwise import Stepwise
from tests.reference.sweep import spread
from tests.reference.virtual_drive import law_of

STEP = 0.0078125
"""A number without rounding [s]."""
OTHER = {"L": 1800.0, "I_B": 200.0, "filter_time": 0.1, "slip_time": 3.0, "Omega_max": 12.0}
OWN = {"c_f": 500.0, "k_f": 350.0, "J_a": 60.0}

_INPUTS = {
    "top_speed": spread(96, 2.0, 14.0, 0.618),
    "top_torque": spread(96, 1000.0, 14000.0, 0.755),
    "speed_ref": spread(96, 7.0, 12.0, 0.057),
}
_TUNED = Stepwise(
    law_of({"filter_time": 0.08}, lambda z, omega: (1.5 * z, 3 * z * omega / 8, 3 * z / (8 * omega))), _INPUTS, STEP
)
_OWN = Stepwise(law_of(OTHER, lambda z, omega: (OWN["c_f"], OWN["k_f"], OWN["J_a"])), _INPUTS, STEP)
_TOLERANCES = {
    "Omega": Tolerance("rounding: waves of up to 1e2 rad/s through some hundred steps, in doubles of 1.1e-16", 1e-11),
    "limit_active": Tolerance("no sample lies within 1e-6 rad/s of the limit"),
}

EXPERIMENTS = (
    Experiment(
        "tuned", "A table tuned by formula, at speeds and torques all over their range",
        _TUNED.stop_time, STEP, 1, _TUNED.answer, _TOLERANCES, inputs=_TUNED.inputs,
    ),
    Experiment(
        "own", "Damping, stiffness and inertia given, on another string, up to the limit",
        _OWN.stop_time, STEP, 1, _OWN.answer, _TOLERANCES, {"mode": "own", **OWN, **OTHER}, _OWN.inputs,
    ),
)  # fmt: skip
