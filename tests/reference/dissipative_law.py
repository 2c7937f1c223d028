"""Reference experiments of DissipativeLaw."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal

from tests.reference.experiment import Experiment, Tolerance
from tests.reference.sweep import STEP, Row, Sweep, spread

GUARD, LIMIT = Decimal("0.01"), Decimal(40)
TRACKING: Mapping[str, float] = {"c_1": 0.65, "c_a": 1800.0, "c_b": 1.5, "Omega_max": 25.0}
_EXACT = Tolerance("no sample lies within 1e-6 rad/s of a threshold")


def printed(row: Row) -> Mapping[str, Decimal | bool]:
    """Eq. (9) of the paper with its default parameters, g = c_a L/(G J) and k = c_b L/(G J), guarded and limited."""
    c_1, c_2, k_over_g = Decimal("0.3"), Decimal(2), Decimal("0.03") / 2000
    top, bit, ref = row["top_speed"], row["bit_speed"], row["bit_speed_ref"]
    divisor = GUARD.copy_sign(top) if abs(top) < GUARD else top
    grouped = c_1 * top + 2 * (1 - c_1).sqrt() * (k_over_g.sqrt() * bit + c_2.sqrt() * ref)
    omega = grouped - ref / divisor * (c_2 * ref + 2 * (c_2 * k_over_g).sqrt() * bit)
    return _limited(omega, LIMIT) | {"guard_active": abs(top) < GUARD}


def tracking(row: Row) -> Mapping[str, Decimal | bool]:
    """Return r + T_ref/c_a + c_1 (y' - r) + 2 sqrt(c_b (1 - c_1)/c_a) (v - r), limited, with `TRACKING`."""
    c_1, c_a, c_b = (Decimal(repr(TRACKING[name])) for name in ("c_1", "c_a", "c_b"))
    ref = row["bit_speed_ref"]
    share = 2 * (c_b / c_a * (1 - c_1)).sqrt()
    omega = ref * (1 - c_1 - share) + row["bit_torque_ref"] / c_a + c_1 * row["top_speed"] + share * row["bit_speed"]
    return _limited(omega, Decimal(repr(TRACKING["Omega_max"]))) | {"guard_active": False}


def _limited(omega: Decimal, limit: Decimal) -> dict[str, Decimal | bool]:
    return {"Omega": min(max(omega, -limit), limit), "limit_active": abs(omega) > limit}


_PRINTED = Sweep(
    printed,
    {
        "top_speed": (0.0, -0.009, 0.004, 0.02, -0.05, *spread(43, -20.0, 25.0, 0.618)),
        "bit_speed": spread(48, -5.0, 25.0, 0.755),
        "bit_speed_ref": (0.2, -0.1, 0.3, 0.5, 0.4, *spread(43, -6.0, 14.0, 0.570)),
    },
)
_TRACKING = Sweep(
    tracking,
    {
        "top_speed": spread(48, -15.0, 30.0, 0.618),
        "bit_speed": spread(48, -15.0, 30.0, 0.755),
        "bit_speed_ref": spread(48, -10.0, 15.0, 0.570),
        "bit_torque_ref": spread(48, -9000.0, 15000.0, 0.324),
    },
)

EXPERIMENTS = (
    Experiment(
        "printed", "The law as printed, with its guard and its limit, at inputs all over their range",
        _PRINTED.stop_time, STEP, 1, _PRINTED.answer,
        {
            "Omega": Tolerance("rounding: terms of up to 1e3 rad/s cancel, in doubles of 1.1e-16", 1e-12, 1e-14),
            "guard_active": _EXACT, "limit_active": _EXACT,
        },
        inputs=_PRINTED.inputs,
    ),
    Experiment(
        "tracking", "The law in tracking form, with other parameters, at inputs all over their range",
        _TRACKING.stop_time, STEP, 1, _TRACKING.answer,
        {
            "Omega": Tolerance("rounding: four terms of at most 30 rad/s, in doubles of 1.1e-16", 1e-13),
            "guard_active": Tolerance("this form divides by nothing"), "limit_active": _EXACT,
        },
        {"form": "tracking", **TRACKING}, _TRACKING.inputs,
    ),
)  # fmt: skip
