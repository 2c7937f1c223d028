"""Reference experiments of DrillingProgram, answered in decimal arithmetic of 40 digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import Decimal, localcontext
from itertools import pairwise

import numpy as np

from tests.reference.experiment import Answers, Experiment, Tolerance
from tests.reference.sweep import DIGITS, columns


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

EXPERIMENTS = (
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
