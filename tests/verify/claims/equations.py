"""The equations themselves: energy balance (8), neutral equations (14) to (16)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from models.plant.parameters import DrillstringParameters
from models.theory.stability.normalised_form import NormalisedForm
from tests.plant.programs import PAPER
from tests.verify.claim import Trial, claim
from tests.verify.finding import Finding
from tests.verify.laws.energy import energy_changes_at_the_rate_of_equation_8, rate_error
from tests.verify.laws.printed import (
    CASES,
    equation_14_holds_as_printed,
    equation_15_holds_as_printed,
    samples,
    torque_on_a_slipping_bit_is_that_of_equations_3_and_4,
)


def _trial(ran: str, finding: Finding) -> Trial:
    if finding.holds:
        return Trial(ran, f"both sides agree within {finding.allowed:.1g} {finding.unit}", True)
    return Trial(ran, f"both sides differ by {finding.found:.1g} {finding.unit}", False)


@claim("(8), section 2.1")
def energy_balance() -> list[Trial]:
    """The energy (7) changes at the rate (8)

    GL in g, k, q and h below (6) is a misprint for GJ.
    """
    finding = energy_changes_at_the_rate_of_equation_8()
    parameters = DrillstringParameters()
    # GL for GJ: L / (G L) in place of L / (G J)
    wrong = parameters.J / parameters.L

    def as_printed(weight: float) -> NormalisedForm:
        form = NormalisedForm.of(parameters, weight)
        return replace(form, g=form.g * wrong, k=form.k * wrong, q=form.q * wrong, h=form.h * wrong)

    error, _ = rate_error(as_printed)
    return [
        _trial("along motions of the plant, g, k, q, h with GJ", finding),
        Trial("the same, with GL as printed", f"both sides differ by {error:.1g} W", error <= finding.allowed),
    ]


@claim("(14), (15), section 2.2")
def neutral_equations() -> list[Trial]:
    """Eqs. (14) and (15) describe both ends of the string that eqs. (1) and (2) describe, with β = 0"""
    return [
        _trial("(14) along motions of the plant", equation_14_holds_as_printed()),
        _trial("(15) along motions of the plant", equation_15_holds_as_printed()),
    ]


@claim("(16), section 2.2")
def friction_of_the_neutral_model() -> list[Trial]:
    """Eq. (16) gives the torque on the bit

    It lacks γ_b, a misprint: with it it is (3) and (4).
    """
    with_gamma = torque_on_a_slipping_bit_is_that_of_equations_3_and_4()
    error = 0.0
    for name, (_, weight) in CASES.items():
        run, _ = samples(name)
        slips = (run["bit_stuck"] == 0) & (run["bit_speed"] != 0.0)
        speed = run["bit_speed"][slips]
        friction = PAPER.mu_cb + (PAPER.mu_sb - PAPER.mu_cb) * np.exp(-np.abs(speed) / PAPER.v_f)
        torque = PAPER.c_b * speed + weight * PAPER.R_b * friction * np.sign(speed)
        error = max(error, float(np.abs(torque - run["bit_torque"][slips]).max()))
    return [
        _trial("with γ_b in the exponent, as in (4)", with_gamma),
        Trial("without γ_b, as printed", f"differs from (4) by up to {error:.0f} N m", error <= with_gamma.allowed),
    ]
