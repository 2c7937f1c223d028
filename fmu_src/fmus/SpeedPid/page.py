"""Write the documentation page of SpeedPid.

Labels "cures n" are numbers of docs/cures.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "The controller",
        paragraphs(r"""
The set point $s$ begins at the speed that is and goes to `speed_ref` at the rate $a$ (`rate_limit`) at most,

$$ |\frac{ds}{dt}| \le a. $$ cures 14

The torque of the motor is

$$ T = K_p (s - \Omega) + \int K_i (s - \Omega) \, dt - K_d \frac{\Omega - \Omega_f}{T_f}, $$ cures 15

where $\Omega_f$ is the speed through a filter of first order with $T_f$ (`filter_time`): the derivative of the speed,
not of the set point.
"""),
    ),
    (
        "Gains by formula",
        paragraphs(r"""
With the impedance $Z$ of the string, the inertia $J_r$ of the rotor and the stick-slip frequency, the lowest root of
$\tan(\omega \Gamma) = Z / (\omega I_B)$,

$$ K_p = 4 Z, \quad K_i = \omega_s^2 J_r \quad \text{(tuned)}; \qquad K_p = 50 Z, \quad K_i = 5 J_r \quad
\text{(stiff)}. $$ cures 16

Tuned, the integral part takes the rotor's inertia away at that frequency, and the string meets a damper. While
`enabled` is false, the gains are those of stiff, an ordinary drive. At a switch the integral part takes over what the
others jump by.
"""),
    ),
    (
        "Limits",
        paragraphs(r"""
$$ T_{\text{min}} \le T \le T_{\text{max}} $$ cures 17

While the torque is at a limit, what would drive it further is not added up.
"""),
    ),
)

LIMITS = phrases(
    "With a rotor of 2900 kg m² and the string's start values neither tuned nor stiff gains free stick-slip at 8 to "
    "10 rad/s: the damper they show reaches the string through the slip $c_a$ and the inertia only near one "
    "frequency. Strings of 3000 and 5000 m are freed by tuned gains and a rotor of 500 kg m² together, by neither "
    "alone.",
    "The rotor's speed is controlled. The same controller on `top_speed`, ahead of the slip, only stiffens the "
    "string: the reflection at its top goes to -1.",
)

USE = phrases(
    "Connect `motor_torque` to TopDrive in mode torque, its `Omega_measured` (or `Omega`) to `Omega`, and "
    "`speed_ref` from DrillingProgram. The communication step is the sample time.",
    "To start in steady drilling, give the torque there as `torque_initial`.",
)
