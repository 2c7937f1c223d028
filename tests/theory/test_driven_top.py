"""A driven top, against equations solved one by one, the delay criterion, and the spectrum of a top that slips."""

from __future__ import annotations

import numpy as np
import pytest

from models.controllers.delay import reflection
from models.controllers.speed_pid import PidGains
from models.controllers.virtual_drive import Gains, TopOfString, VirtualDrive, absorber, soft_torque
from models.theory import DrillstringParameters, rightmost_roots
from models.theory.stability.driven_top import (
    FREQUENCIES,
    Follower,
    RotorTop,
    VirtualTop,
    greatest_reflection,
    modal_damping,
)
from models.theory.stability.equilibrium import running_equilibrium

STRING, KNOWN = DrillstringParameters(), TopOfString()
Z, C_A = STRING.impedance, STRING.c_a
LAWS = {
    "soft": VirtualDrive(Z, C_A, soft_torque(KNOWN), 0.04, 5.0, False),
    "compensated": VirtualDrive(Z, C_A, soft_torque(KNOWN, 1.0), 0.1, 5.0, True),
    "absorber": VirtualDrive(Z, C_A, absorber(KNOWN), 0.08, 5.0, False),
    "mistaken": VirtualDrive(0.5 * Z, 0.7 * C_A, soft_torque(KNOWN), 0.04, 2.0, False),
    "without a spring": VirtualDrive(Z, C_A, Gains(400.0, 0.0, 30.0), 0.0, 5.0, False),
}
DRIVES = {
    "speed": Follower(0.02, 0.015),
    "servo": Follower(0.0, 0.005, 2900.0, 15000.0, 14500.0),
}


def solved(law: VirtualDrive, drive: Follower, s: complex) -> complex:
    """The wave sent down for one that comes up, with each equation of the law's page as a row."""
    names = ["down", "y", "tau", "wave", "filtered", "slip", "u", "q", "command", "Omega"]
    at = {name: number for number, name in enumerate(names)}
    P, K, J = law.gains
    Zm, c = law.impedance, law.slip
    rows: list[tuple[dict[str, complex], complex]] = [
        ({"y": 1, "down": -1}, 1),
        ({"tau": 1, "down": -Z}, -Z),
        ({"tau": 1, "Omega": -C_A, "y": C_A}, 0),
        ({"wave": 1, "y": -0.5, "tau": 0.5 / Zm}, 0),
        ({"filtered": 1 + s * law.filter_time, "wave": -1}, 0),
        ({"slip": 1 + s * law.slip_time, "tau": 0 if law.compensated else 1 / c}, 0),
        ({"u": J * s + P + Zm, "q": K, "slip": -Zm, "filtered": 2 * Zm}, 0),
        ({"q": s, "u": -1}, 0),
        ({"command": c, "slip": -(c + Zm), "u": c + Zm, "filtered": (c + Zm) - (c - Zm)}, 0),
    ]
    late = np.exp(-s * drive.delay)
    if drive.inertia:
        control = drive.proportional + drive.integral / s
        rows.append(({"Omega": drive.inertia * s + control, "command": -control * late, "tau": 1}, 0))
    else:
        rows.append(({"Omega": 1 + s * drive.lag, "command": -late}, 0))
    matrix = np.zeros((len(names), len(names)), complex)
    for row, (parts, _) in enumerate(rows):
        for name, value in parts.items():
            matrix[row, at[name]] += value
    return complex(np.linalg.solve(matrix, np.array([right for _, right in rows], complex))[at["down"]])


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("law", LAWS)
def test_the_wave_sent_down_solves_the_equations_of_law_drive_and_slip(law: str, drive: str) -> None:
    top = VirtualTop(STRING, LAWS[law], DRIVES[drive])
    for s in (0.05j, 1.9j, 2.5j - 0.2, 30j, 300j, 0.4 + 7j):
        down, up = (complex(part[0]) for part in top.waves(np.array([s])))
        assert up / down == pytest.approx(solved(LAWS[law], DRIVES[drive], s), rel=1e-9)


def test_without_a_lag_the_reflection_is_that_of_the_delay_criterion() -> None:
    law = LAWS["compensated"]
    top = VirtualTop(STRING, law, Follower(0.0, 0.07))
    found = max(reflection(Z, C_A, law.gains, law.filter_time, 0.07, w) for w in FREQUENCIES.tolist())
    assert found > 1.0
    assert greatest_reflection(top) == pytest.approx(found, rel=1e-9)


def test_a_rotor_meets_the_string_as_inertia_controller_and_slip_in_a_row() -> None:
    gains = PidGains(1200.0, 18000.0, 40.0)
    s = 3.7j
    rotor = 500.0 * s + (1200.0 + 18000.0 / s + 40.0 * s / (1 + 0.05 * s)) * np.exp(-0.02 * s)
    met = 1 / (1 / rotor + 1 / C_A)
    down, up = (complex(part[0]) for part in RotorTop(STRING, gains, 0.05, 500.0, 0.02).waves(np.array([s])))
    assert up / down == pytest.approx((Z - met) / (Z + met), rel=1e-12)


@pytest.mark.parametrize(("speed", "weight"), [(10.0, 97347.0), (8.0, 97347.0), (20.0, 97347.0), (8.0, 40e3)])
def test_a_rotor_that_nothing_moves_leaves_the_spectrum_of_a_top_that_slips(speed: float, weight: float) -> None:
    held = RotorTop(STRING, PidGains(1e12, 0.0, 0.0), 0.05, 1.0, 0.0)
    slope = running_equilibrium(STRING, speed, weight).slope
    assert slope is not None
    rightmost = float(rightmost_roots(STRING, speed, weight, 1)[0].real)
    assert modal_damping(held, slope) == pytest.approx(-rightmost, abs=1e-7)


def test_fifty_milliseconds_of_delay_make_small_motions_grow_and_a_longer_filter_does_not() -> None:
    """docs/cures.md: SoftTorque behind 50 ms of delay swings, and with a filter of 0.16 s it does not."""
    slope = running_equilibrium(STRING, 9.0, 97347.0).slope
    assert slope is not None

    def damping(filter_time: float, delay: float) -> float:
        law = VirtualDrive(Z, C_A, soft_torque(KNOWN), filter_time, 5.0, False)
        return modal_damping(VirtualTop(STRING, law, Follower(0.02, delay)), slope)

    assert damping(0.04, 0.005) > 0.1
    assert damping(0.04, 0.055) < -0.05
    assert damping(0.16, 0.055) > 0.0


def test_what_cannot_be_counted_is_said() -> None:
    """Of gains that are no numbers nothing can be told."""
    with pytest.raises(ArithmeticError, match="slowest"):
        modal_damping(RotorTop(STRING, PidGains(float("nan"), 0.0, 0.0), 0.05, 1.0, 0.0), 0.0)
