"""The work a second of the string takes, and the bound beyond which it is refused.

It is counted in blocks of the start values: what both ends take of one, 180 ns. A string divided into M blocks brings M
of them in a travel time; where the bit answers its torque faster than that, pieces are as short as its answer
(`GREATEST_STIFFNESS`). With damping along the string two times M blocks cross in each of the M blocks.

What the parameters ask for at all times is refused before the start. How the bit moves is not known by then: where it
is thrown about, pieces are halved until a quartic follows its speed. So the bit has a credit, which it spends by being
followed, and earns as time goes by; a step in which it is spent is refused. How often inputs change is up to who sets
them: what a change brings adds to the credit.
"""

from __future__ import annotations

from .parameters import DistributedParameters, DrillstringParameters
from .slip import GREATEST_STIFFNESS

START_BLOCKS = 250.0
"""Blocks a second of the start values [1/s]."""

PIECE = 0.5
"""Work of a piece of the bit beside its collocation, with what its break costs elsewhere."""

HALVING = 0.15
"""Work of halving a piece, however often."""

SHORTENED = 2.0
"""Work of the pieces in the time in which the bit answers, measured: up to twice as many, of 260 ns."""

CROSSING = 0.12
"""Work of two blocks that cross, measured: 24 ns."""

START_DAMPED = 6000.0
"""Work a second of the start values with the crossings of a little damping [1/s]."""

MOST_ASKED = 40.0
"""Greatest multiple of these that parameters may ask for."""

MOST_TIMES = 50.0
"""Greatest multiple with what the motion takes beside."""

START_RATE = MOST_TIMES * START_BLOCKS
"""Work a second that following the bit of a string without damping may take [1/s]."""

SAVED = 0.25
"""Time whose earnings can be saved, and are there at the start [s]."""

INPUT_CREDIT = 100.0
"""What a change of an input earns: a jump comes back to the bit until it has faded."""


class TooMuchWorkError(ArithmeticError):
    """Refuse to follow the bit any further."""

    def __init__(self, time: float) -> None:
        super().__init__(
            f"at t = {time:.9g} s the bit moves so fast that a second takes more than {MOST_TIMES:g} times the work of "
            "the start values: set a greater I_B, or change torque and weight less"
        )


def earning(beta: float, travel_time: float, blocks: int) -> float:
    """Return the work a second that following a bit may take [1/s]: what blocks that cross leave, or `START_RATE`.

    Parameters
    ----------
    beta : float
        Damping along the string [N s/rad].
    travel_time : float
        In s.
    blocks : int
        Blocks in a travel time.
    """
    if not beta > 0.0:
        return START_RATE
    left = MOST_TIMES * START_DAMPED - CROSSING * (2.0 * blocks * (blocks / travel_time))
    return left if left > START_RATE else START_RATE


def refusal(parameters: DrillstringParameters, blocks: int, asked: int) -> str | None:
    """Return why a string in so many blocks takes too much work, None if it does not.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    blocks : int
        Blocks in a travel time.
    asked : int
        Of these, the blocks that its cells ask for; more are asked for by its damping.
    """
    brought = blocks / parameters.travel_time
    answered = (parameters.impedance + parameters.c_b) / (parameters.I_B * GREATEST_STIFFNESS)
    ends = SHORTENED * answered if answered > brought else brought
    damped = isinstance(parameters, DistributedParameters) and parameters.beta > 0.0
    crossings = 2.0 * blocks * brought
    times = (ends + CROSSING * crossings) / START_DAMPED if damped else ends / START_BLOCKS
    if times <= MOST_ASKED:
        return None
    if answered > brought:
        remedy = "a greater I_B or a lower c_b"
    elif damped and blocks > asked:
        remedy = "a lower beta or a shorter L"
    else:
        remedy = "fewer cells or a shorter L" if damped else "fewer cells or a longer L"
    return (
        f"a second takes {times:.4g} times the work of the start values; expected at most {MOST_ASKED:g}: set {remedy}"
    )
