"""Find where the energy of the string grows along a run with law (9), by how much, and why: Proposition 1 put to it.

The proposition says that it never does, if the law is obeyed at every instant. Over each step the plant tells how its
energy changed and the work that was done on it at the top. Models tell the work had the law been obeyed at the motion
there was (`models.theory.lawful_energy`), and whether any drive speed obeys it with the wave that arrives
(`models.theory.loop_set`). Where energy grew although the law's own work would not have covered the losses, what drove
the string was not the law's value: one that a guard or a limit made, or an old one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.drilling.mathematics import (
    BoolArray,
    DissipativeLaw,
    DrillstringParameters,
    PrintedLoop,
    TopMotion,
    lawful_angle,
    lawful_work,
)
from cosim.errors import InputError
from cosim.recording.result import Result
from cosim.system.signals import FloatArray

CAUSES = (
    "law",
    "limit",
    "guard",
    "sampling",
    "no solution: limit",
    "no solution: guard",
    "no solution: sampling",
)
"""The causes of growth, see :class:`EnergyGrowth`."""
_UNSOLVABLE = 3
"""The distance, in the list of causes, from one to the same where the loop had no solution."""
_HELD = 1e-9
"""A drive is held if its work says so to this part."""
_ROUNDING = 1e-12
"""Changes below this part of the greatest energy are rounding, and no growth."""
_PASSED_ON = 1e-6
"""A value passed on agrees to this part."""


@dataclass(frozen=True)
class Share:
    """Growth of energy that one cause made.

    Attributes
    ----------
    steps : int
        Steps in which the energy grew.
    growth : float
        By how much in all of them, J.
    excess : float
        Work into the string beyond what the law would have done, in all of them, J.
    first : float
        End of the first of them, s; NaN if there is none.
    """

    steps: int
    growth: float
    excess: float
    first: float


@dataclass(frozen=True)
class EnergyGrowth:
    """Growth of the energy of a string, step by step, with its causes.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Ends of steps, s; row 0 is the start, where nothing has changed.
    change : ndarray, shape (n,)
        Of the energy in the step, J.
    excess : ndarray, shape (n,)
        Work into the string beyond what the law would have done at the motion there was, J.
    lawful : ndarray, shape (n,)
        What the change would have been without the excess, J. With the printed form never above 0, but for rounding:
        this is Proposition 1.
    solvable : ndarray of bool, shape (n,)
        Whether any drive speed obeys the law at the end of the step.
    cause : ndarray of int, shape (n,)
        In `CAUSES`, -1 where the energy does not grow:

        - ``law``: the law's own work exceeds the losses, it asks for growth;
        - ``limit``, ``guard``: these made the drive speed;
        - ``sampling``: the drive speed was the law's, but at a communication point and not at every instant;
        - ``no solution: ...``: the same, where no drive speed would have obeyed the law.
    """

    time: FloatArray
    change: FloatArray
    excess: FloatArray
    lawful: FloatArray
    solvable: BoolArray
    cause: NDArray[np.intp]

    @property
    def growth(self) -> float:
        """Sum the growth over all steps in which the energy grew, J."""
        return float(self.change[self.cause >= 0].sum())

    def shares(self) -> dict[str, Share]:
        """Return what each cause made; the growths sum to that of all steps."""
        found: dict[str, Share] = {}
        for number, name in enumerate(CAUSES):
            rows = np.flatnonzero(self.cause == number)
            first = float(self.time[rows[0]]) if rows.size else float("nan")
            found[name] = Share(rows.size, float(self.change[rows].sum()), float(self.excess[rows].sum()), first)
        return found


def energy_growth(result: Result, plant: str = "plant", law: str = "law") -> EnergyGrowth:
    """Say where the energy of a string grew under law (9), and why.

    The product of the two speeds is integrated with the mean of the bit speed over each step. It enters times
    sqrt(c_a c_b); everything else is exact, whatever the speeds do within a step.

    Parameters
    ----------
    result : Result
        A run, by :func:`cosim.simulate`.
    plant, law : str
        Names of the components; the law drives the plant, with no other component between.

    Raises
    ------
    InputError
        Something this is taken from was not recorded.
    """
    string, obeyed = _string(result, plant), _law(result, law)
    motion, _ = _motion(result, plant, law, string.c_a)
    refs = (_column(result, f"{law}.{name}")[1:] for name in ("bit_speed_ref", "bit_torque_ref"))
    excess = _changes(result, f"{plant}.work_in") - lawful_work(obeyed, string.c_a, motion, *refs)
    change = _changes(result, f"{plant}.energy")
    solvable = _solvable(result, plant, law, string, obeyed)
    return _attributed(result, plant, law, change, excess, solvable)


def deviation_growth(result: Result, plant: str = "plant", law: str = "law") -> EnergyGrowth:
    """Say where the energy of the deviations from the wanted rotation grew under law (9) in tracking form, and why.

    It is the energy that string and bit would have if they turned by what they deviate from rotation with the wanted
    speed and torque. The tracking form is to it what the printed form is to the energy itself, but for the dry
    friction, which falls: where the cause is ``law``, that feeds it. The torque on bit is taken to go on straight lines
    between communication points; else as in :func:`energy_growth`, whose parameters these are.

    Raises
    ------
    InputError
        Something this is taken from was not recorded, the law is of the printed form, what is wanted changes, or the
        string is damped: then it cannot turn with the wanted torque everywhere.
    """
    string, obeyed = _string(result, plant), _law(result, law)
    speed, torque = _wanted_rotation(result, plant, law, obeyed)
    motion, drive_angle = _motion(result, plant, law, string.c_a)
    refs = np.full_like(motion.top, speed), np.full_like(motion.top, torque)
    excess = _changes(result, f"{plant}.work_in") - lawful_work(obeyed, string.c_a, motion, *refs)
    excess = excess - speed * string.c_a * (drive_angle - lawful_angle(obeyed, motion, *refs))
    on_bit = _column(result, f"{plant}.bit_torque")
    impulse = string.c_a * (drive_angle - motion.top) - 0.5 * motion.duration * (on_bit[1:] + on_bit[:-1])
    change = _changes(result, f"{plant}.energy") - speed * impulse - torque * (motion.top - motion.bit)
    return _attributed(result, plant, law, change, excess, np.ones(result.time.size, dtype=np.bool_))


def _wanted_rotation(result: Result, plant: str, law: str, obeyed: DissipativeLaw) -> tuple[float, float]:
    """Return the wanted bit speed and torque on bit, which must not change."""
    if obeyed.form != "tracking":
        raise InputError(f"{law} is of the {obeyed.form} form; expected the tracking form, which knows a wanted torque")
    lost = f"{plant}.string_loss"
    if lost in result and result[lost][-1] != result[lost][0]:
        raise InputError(f"{plant} is damped along its length; expected a string without")
    for name in ("bit_speed_ref", "bit_torque_ref"):
        if np.ptp(_column(result, f"{law}.{name}")) > 0.0:
            raise InputError(f"{law}.{name} changes; expected a constant")
    return float(_column(result, f"{law}.bit_speed_ref")[0]), float(_column(result, f"{law}.bit_torque_ref")[0])


def _attributed(
    result: Result, plant: str, law: str, change: FloatArray, excess: FloatArray, solvable: BoolArray
) -> EnergyGrowth:
    """Name the cause of the growth in each step."""
    least = _ROUNDING * float(_column(result, f"{plant}.energy").max())
    lawful = change - excess
    cause = _sources(result, plant, law) + np.where(solvable[1:], 0, _UNSOLVABLE)
    cause = np.where(lawful > least, 0, cause)
    first = np.zeros(1)
    return EnergyGrowth(
        time=result.time,
        change=np.concatenate([first, change]),
        excess=np.concatenate([first, excess]),
        lawful=np.concatenate([first, lawful]),
        solvable=solvable,
        cause=np.concatenate([[-1], np.where(change > least, cause, -1)]).astype(np.intp),
    )


def incident_wave(result: Result, plant: str = "plant") -> FloatArray:
    """Return the wave that arrives at the top, U(t - Gamma) [rad/s], shape (n,), from speed and torque there."""
    impedance = _string(result, plant).impedance
    return 0.5 * (_column(result, f"{plant}.top_speed") - _column(result, f"{plant}.top_torque") / impedance)


def _motion(result: Result, plant: str, law: str, top_damping: float) -> tuple[TopMotion, FloatArray]:
    """Integrate the motion over each step, and the drive speed; the square of the top speed follows from work done."""
    duration = np.diff(result.time)
    top, bit = (_changes(result, f"{plant}.{name}") for name in ("top_angle", "bit_angle"))
    given, worked = (_changes(result, f"{plant}.{name}") / top_damping for name in ("drive_work", "work_in"))
    last = _column(result, f"{plant}.Omega")[1:]
    held = np.abs(given - last * (last * duration - top)) <= _HELD * np.maximum(last * last, 1.0) * duration
    first = np.where(held, last, _column(result, f"{law}.Omega")[:-1])
    # of Omega^2 on a straight line, less of (Omega - ydot) Omega: of Omega ydot
    crossed = duration / 3.0 * (first * first + first * last + last * last) - given
    motion = TopMotion(duration, top, bit, crossed - worked, top * (bit / duration))
    return motion, 0.5 * duration * (first + last)


def _sources(result: Result, plant: str, law: str) -> NDArray[np.intp]:
    """Return what made the drive speed in force at the end of each step: the law as it was there, or a step before."""
    asked, driven = _column(result, f"{law}.Omega"), _column(result, f"{plant}.Omega")[1:]
    current, before = np.abs(driven - asked[1:]), np.abs(driven - asked[:-1])
    late = before < current
    if np.minimum(current, before).max(initial=0.0) > _PASSED_ON * max(1.0, np.abs(asked).max()):
        raise InputError(f"{plant}.Omega is not {law}.Omega, of now or a step before; expected {law} to drive {plant}")
    sources = np.full(driven.size, CAUSES.index("sampling"), dtype=np.intp)
    for name in ("limit", "guard"):
        flags = np.asarray(result[f"{law}.{name}_active"], dtype=np.bool_)
        sources[np.where(late, flags[:-1], flags[1:])] = CAUSES.index(name)
    return sources


def _solvable(result: Result, plant: str, law: str, string: DrillstringParameters, obeyed: DissipativeLaw) -> BoolArray:
    """Return at which communication points some drive speed obeys the law: always one that of the tracking form."""
    wanted = _column(result, f"{law}.bit_speed_ref")
    found = np.ones(wanted.size, dtype=np.bool_)
    if obeyed.form == "printed":
        wave, bit = incident_wave(result, plant), _column(result, f"{plant}.bit_speed")
        order = np.argsort(wanted, kind="stable")
        values, starts = np.unique(wanted[order], return_index=True)
        for value, rows in zip(values.tolist(), np.split(order, starts[1:]), strict=True):
            found[rows] = PrintedLoop.of(string, obeyed, value).solvable(bit[rows], wave[rows])
    return found


def _string(result: Result, plant: str) -> DrillstringParameters:
    """Read the string a run was made with."""
    return DrillstringParameters(**_parameters(result, plant, ("G", "J", "I", "L", "I_B", "c_a", "c_b")))


def _law(result: Result, law: str) -> DissipativeLaw:
    """Read the law a run was made with."""
    return DissipativeLaw(**_parameters(result, law, ("form", "c_1", "c_2", "c_a", "c_b")))


def _parameters(result: Result, component: str, names: Sequence[str]) -> Mapping[str, Any]:
    """Return parameters that a component ran with from beginning to end."""
    try:
        given = result.record["components"][component]["parameters"]
    except KeyError:
        raise InputError(
            f"the record of the run tells no parameters of '{component}'; expected a run by simulate"
        ) from None
    for name in names:
        if name not in given:
            raise InputError(f"{component}.{name} is driven by a signal; expected a parameter that does not change")
    return {name: given[name] for name in names}


def _column(result: Result, name: str) -> FloatArray:
    """Return a trajectory as numbers."""
    return np.asarray(result[name], dtype=np.float64)


def _changes(result: Result, name: str) -> FloatArray:
    """Return by how much a quantity changed in each step."""
    return np.diff(_column(result, name))
