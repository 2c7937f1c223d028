"""Eqs. (18) to (21): formal stability, and what it does not tell."""

from __future__ import annotations

from dataclasses import asdict, replace

from models.plant.parameters import DrillstringParameters
from models.theory.stability.equilibrium import running_equilibrium
from models.theory.stability.neutral_form import neutral_form
from models.theory.stability.spectrum import roots_about
from tests.oracle import OracleParameters
from tests.verify.claim import Trial, claim
from tests.verify.claims.runs import NOMINAL_WEIGHT
from tests.verify.laws.spectra import winding

PAPER = DrillstringParameters()
ROOTS = 40


@claim("(21), section 2.2")
def formal_stability() -> list[Trial]:
    """|Υ| < 1 for all c_a > 0, so the neutral model is formally stable

    The margin vanishes for c_a to 0 and for c_a to infinity.
    """
    trials: list[Trial] = []
    for top in (0.001, 20.0, 300.0, 2000.0, 1e6):
        parameters = replace(PAPER, c_a=top)
        operator = neutral_form(parameters).difference
        told = f"|Υ| = {abs(parameters.reflection):.7f}, zeros of det(I - Ê) at Re s ≤ {operator.abscissa:.3g} 1/s"
        holds = abs(parameters.reflection) < 1.0 and operator.formally_stable
        trials.append(Trial(f"rank condition (18), c_a = {top:g} N m s", told, holds))
    return trials


@claim("section 2.2")
def finitely_many_unstable_roots() -> list[Trial]:
    """A formally stable system has only a finite number of zeros in the right half plane

    A finite number need not be none: formal stability is necessary for stability and not sufficient.
    """
    trials: list[Trial] = []
    string = OracleParameters(**asdict(PAPER))
    for omega in (7.0, 8.0, 8.5, 10.0):
        rotation = running_equilibrium(PAPER, omega, NOMINAL_WEIGHT)
        count = winding(string, NOMINAL_WEIGHT, rotation.speed)
        right = int((roots_about(PAPER, rotation, ROOTS).real > 0.0).sum())
        told = f"{count} by the phase of the characteristic function, {right} of the {ROOTS} rightmost roots"
        told += f": {'unstable' if count else 'stable'}"
        trials.append(Trial(f"rotation at Ω = {omega:g} rad/s", told, count == right < ROOTS))
    return trials
