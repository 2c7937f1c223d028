"""Reference experiments of SoftTorque."""

from __future__ import annotations

from tests.reference.experiment import Experiment, Tolerance
from tests.reference.stepwise import Stepwise
from tests.reference.sweep import spread
from tests.reference.virtual_drive import law_of

STEP = 0.0078125
"""A number without rounding [s]."""
OTHER = {"G": 8e10, "L": 2000.0, "I_B": 311.0, "c_a": 1500.0, "filter_time": 0.1, "slip_time": 2.0, "Omega_max": 12.0}
OWN = {"P": 380.0, "K": 120.0, "J_v": 55.0}

_INPUTS = {
    "top_speed": spread(96, -5.0, 20.0, 0.618),
    "top_torque": spread(96, -4000.0, 16000.0, 0.755),
    "speed_ref": spread(96, 6.0, 12.0, 0.057),
}
_SOFT = Stepwise(law_of({}, lambda z, omega: (1.5 * z, 1.5 * z * omega / 6, 0)), _INPUTS, STEP)
_OWN = Stepwise(law_of(OTHER, lambda z, omega: tuple(OWN.values()), compensated=True), _INPUTS, STEP)
_TOLERANCES = {
    "Omega": Tolerance("rounding: waves of up to 1e2 rad/s through some hundred steps, in doubles of 1.1e-16", 1e-11),
    "limit_active": Tolerance("no sample lies within 1e-6 rad/s of the limit"),
}

EXPERIMENTS = (
    Experiment(
        "soft-torque", "Gains by formula, at speeds and torques all over their range",
        _SOFT.stop_time, STEP, 1, _SOFT.answer, _TOLERANCES, inputs=_SOFT.inputs,
    ),
    Experiment(
        "own", "Damping, stiffness and inertia given, on another string, slip compensated",
        _OWN.stop_time, STEP, 1, _OWN.answer, _TOLERANCES,
        {"mode": "own", "slip": "compensated", **OWN, **OTHER}, _OWN.inputs,
    ),
)  # fmt: skip
