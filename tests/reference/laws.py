"""Reference experiments of laws and program: sweeps answered by closed forms in decimal arithmetic of 40 digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal, localcontext
from itertools import pairwise

import numpy as np

from tests.reference.experiment import Answers, Experiment, Points, Tolerance, held

STEP = 0.25
"""Communication step size of the sweeps; every one of its multiples is a number without rounding [s]."""
GUARD, LIMIT = Decimal("0.01"), Decimal(40)
DIGITS = 40

Row = Mapping[str, Decimal]
Formula = Callable[[Row], Mapping[str, Decimal | bool]]

_EXACT = Tolerance("no sample lies within 1e-6 rad/s of a threshold")


def spread(count: int, low: float, high: float, stride: float) -> tuple[float, ...]:
    """Return numbers all over a range, in no order, with at most three digits after the point."""
    return tuple(round(low + (high - low) * ((0.5 + index * stride) % 1.0), 3) for index in range(count))


class Sweep:
    """Inputs held for one step each, and what a law without memory makes of them.

    Parameters
    ----------
    formula : callable
        From the inputs to the outputs.
    columns : mapping of str to sequence of float
        The values each input takes, one for each step.
    """

    def __init__(self, formula: Formula, columns: Mapping[str, Sequence[float]]) -> None:
        self._formula, self._columns = formula, columns

    @property
    def inputs(self) -> Mapping[str, Points]:
        """The inputs over time."""
        return {
            name: held(*((index * STEP, value) for index, value in enumerate(values)))
            for name, values in self._columns.items()
        }

    @property
    def stop_time(self) -> float:
        """When the last values have been held for a step [s]."""
        return len(next(iter(self._columns.values()))) * STEP

    def answer(self, times: np.ndarray, step_size: float) -> Answers:
        """Return the outputs: at a communication point they are those of the step that ends there."""
        with localcontext() as context:
            context.prec = DIGITS
            places = [max(round(time / step_size) - 1, 0) for time in times]
            rows = [{name: Decimal(values[place]) for name, values in self._columns.items()} for place in places]
            return columns([self._formula(row) for row in rows])


def columns(rows: Sequence[Mapping[str, Decimal | bool]]) -> Answers:
    """Turn rows of exact answers into columns of the nearest doubles."""
    return {
        name: np.array([row[name] if isinstance(row[name], bool) else float(row[name]) for row in rows])
        for name in rows[0]
    }


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


def weight(row: Row) -> Mapping[str, Decimal]:
    """Eq. (22) of the paper with its limit, and the default parameters."""
    return {"WOB": min(5000 * abs(row["bit_speed"]) + 97347, Decimal(300000))}


TRACKING: Mapping[str, float] = {"c_1": 0.65, "c_a": 1800.0, "c_b": 1.5, "Omega_max": 25.0}

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
_WEIGHT = Sweep(weight, {"bit_speed": (0.0, -0.0, 40.53, 40.54, -40.54, *spread(35, -60.0, 60.0, 0.618))})

DISSIPATIVE_LAW = (
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

WEIGHT_ON_BIT_LAW = (
    Experiment(
        "sweep", "Bit speeds of both signs, up to where the weight is limited",
        _WEIGHT.stop_time, STEP, 1, _WEIGHT.answer,
        {"WOB": Tolerance("rounding: two operations on at most 3e5 N, in doubles of 1.1e-16", 1e-10)},
        inputs=_WEIGHT.inputs,
    ),
)  # fmt: skip


class Program:
    """The driller's program on straight lines through points of exact numbers.

    Parameters
    ----------
    speed, weight : sequence of (str, str)
        Times [s] and values [rad/s, N]; a jump where two share a time, at which the later one counts.
    friction : mapping of str to float
        Parameters of the torque on bit.
    """

    def __init__(
        self, speed: Sequence[tuple[str, str]], weight: Sequence[tuple[str, str]], friction: Mapping[str, float]
    ) -> None:
        self._speed, self._weight, self._friction = speed, weight, friction

    def answer(self, times: np.ndarray, step_size: float) -> Answers:
        """Return what is asked for at times [s], and the torque on bit (3)-(4) that goes with it."""
        with localcontext() as context:
            context.prec = DIGITS
            return columns([self._row(Decimal(repr(float(time)))) for time in times])

    def _row(self, time: Decimal) -> Mapping[str, Decimal | bool]:
        speed, weight = _on_line(self._speed, time), _on_line(self._weight, time)
        f = {name: Decimal(repr(value)) for name, value in self._friction.items()}
        mu = f["mu_cb"] + (f["mu_sb"] - f["mu_cb"]) * (-f["gamma_b"] * abs(speed) / f["v_f"]).exp()
        dry = weight * f["R_b"] * mu * (Decimal(1).copy_sign(speed) if speed else 0)
        rotation = dict.fromkeys(("Omega", "speed_ref", "bit_speed_ref"), speed)
        return {**rotation, "WOB": weight, "bit_torque_ref": f["c_b"] * speed + dry}


def _on_line(points: Sequence[tuple[str, str]], time: Decimal) -> Decimal:
    exact = [(Decimal(at), Decimal(value)) for at, value in points]
    for (begin, left), (end, right) in pairwise(exact):
        if begin <= time < end:
            return left + (right - left) * (time - begin) / (end - begin)
    return exact[0][1] if time < exact[0][0] else exact[-1][1]


_PAPER = {"c_b": 0.03, "R_b": 0.155575, "mu_cb": 0.5, "mu_sb": 0.8, "gamma_b": 0.9, "v_f": 1.0}
_OTHER = {"c_b": 12.0, "R_b": 0.11, "mu_cb": 0.35, "mu_sb": 0.65, "gamma_b": 0.4, "v_f": 2.5}
_ASKED = {
    **dict.fromkeys(
        ("Omega", "speed_ref", "bit_speed_ref"), Tolerance("rounding on a line of at most 12 rad/s", 1e-14 * 10)
    ),
    "WOB": Tolerance("rounding on a line of at most 1.1e5 N", 1e-9),
    "bit_torque_ref": Tolerance("rounding, and an exponential good to one unit in the last place, at 1.5e4 N m", 1e-10),
}

DRILLING_PROGRAM = (
    Experiment(
        "ramp-and-step", "Rotation run up on a ramp; weight in a step, which an output follows at the very instant",
        20.0, 0.125, 2,
        Program([("2", "0"), ("12", "12")], [("8", "20000"), ("8", "97347")], _PAPER).answer, _ASKED,
        {
            "speed_initial": 0.0, "speed_final": 12.0, "speed_start": 2.0, "speed_duration": 10.0,
            "WOB_initial": 20000.0, "WOB_final": 97347.0, "WOB_start": 8.0, "WOB_duration": 0.0,
        },
    ),
    Experiment(
        "reversal", "Rotation reversed through rest while the weight is taken off, on another bit",
        20.0, 0.125, 2,
        Program([("1.03", "9.5"), ("17.43", "-6.25")], [("-2.5", "110000"), ("15.5", "35000")], _OTHER).answer, _ASKED,
        {
            "speed_initial": 9.5, "speed_final": -6.25, "speed_start": 1.03, "speed_duration": 16.4,
            "WOB_initial": 110000.0, "WOB_final": 35000.0, "WOB_start": -2.5, "WOB_duration": 18.0, **_OTHER,
        },
    ),
)  # fmt: skip
