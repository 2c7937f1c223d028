"""Write the documentation page of DissipativeLaw.

Labels "Eq. (n)" are numbers of the paper, "model n" those of docs/model.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "As printed",
        paragraphs(r"""
With `form` = printed, the top speed $\dot{y}$, the bit speed $v$ and the wanted bit speed $r$ (`bit_speed_ref`),

$$ \Omega = c_1 \dot{y} + 2 \sqrt{\frac{c_b}{c_a} (1 - c_1)} \, v + 2 \sqrt{c_2 (1 - c_1)} \, r
- \frac{c_2 r^2}{\dot{y}} - 2 \sqrt{\frac{c_2 c_b}{c_a}} \, \frac{v r}{\dot{y}}. $$ Eq. (9)

Where $|\dot{y}|$ is less than `top_speed_min`, the divisor is `top_speed_min` with the sign of $\dot{y}$, that of +0
being positive, and `guard_active` is true. The result is kept within

$$ -\Omega_{\text{max}} \le \Omega \le \Omega_{\text{max}}, $$ model 18

and `limit_active` says whether that has changed it. A value found with guard or limit active is not a solution of
Eq. (9).
"""),
    ),
    (
        "In deviations from the wanted rotation",
        paragraphs(r"""
With `form` = tracking, the same completion of the square, given the torque on bit $T_{\text{ref}}$ (`bit_torque_ref`)
that goes with the wanted speed:

$$ \Omega = r + \frac{T_{\text{ref}}}{c_a} + c_1 (\dot{y} - r) + 2 \sqrt{\frac{c_b}{c_a} (1 - c_1)} \, (v - r)
$$ model 19

Without its last term this is the string with $c_a (1 - c_1)$ in place of $c_a$; $c_1 = 1 - Z / c_a$ absorbs every wave
that arrives at the top. The limit of model 18 holds here as well.
"""),
    ),
)

LIMITS = phrases(
    "**The printed form cannot hold a drilling speed**, as said above.",
    "In the tracking form the energy of the deviations grows only by what the falling slope of the friction feeds "
    r"into them. A stuck bit is certain to come loose only if $c_a (1 - c_1) r + T_{\text{ref}}$ exceeds the "
    r"static friction; near $c_1 = 1 - Z / c_a$ it stays stuck.",
    "`c_a` and `c_b` must be those of the plant.",
)

VERDICT = paragraphs(r"""
**As printed, law (9) cannot hold a drilling speed.** With dry friction it drains the energy for as long as the bit
turns, so there is no equilibrium in which the bit turns. At rest, law and string together have no solution at all, for
any $c_1$, $c_2$ and reference. Sampled, the law chatters through its pole at top speed 0, and what the bit then does is
made by `Omega_max` and the step size: every millisecond and with the limit of 40 rad/s it hovers round 10 rad/s, which
looks like success and is an accident. With 100 rad/s it hovers round 15 rad/s; behind a drive with 5 ms of lag the
string stops.

Set `form` to tracking (2) to drill. It is the same completion of the square, in deviations from the wanted rotation.
""")

USE = phrases(
    "Set `form` to tracking (2).",
    "Connect `top_speed` and `bit_speed` from the string, `bit_speed_ref` and `bit_torque_ref` from "
    "DrillingProgram, and `Omega` to the string. `bit_torque_ref` is the torque on bit at the wanted speed and "
    "weight.",
    "Law and string form an algebraic loop. Co-simulation masters open it by one communication step, so the step "
    "is the law's sample time: take 0.001 s. A tool that refuses the loop wants a unit delay in the connection of "
    "`Omega`.",
    r"Choose `c_1` between 0 and $1 - Z / c_a$, which absorbs every wave (0.850 with the start values of the "
    "string). From rest, up to 0.77 breaks a stuck bit loose there.",
    "Watch `limit_active` and `guard_active`: while one of them is true, `Omega` is not what the law asks for.",
)
