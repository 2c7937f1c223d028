"""Write the documentation page of SoftTorque.

Labels "cures n" are numbers of docs/cures.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

VIRTUAL_DRIVE: Sections = (
    (
        "The wave that comes up, and the one sent down",
        paragraphs(r"""
With the speed $y$ (`top_speed`) and torque $\tau$ (`top_torque`) at the top of the string, and its impedance
$Z = \sqrt{I G J}$, the wave that comes up is

$$ U = \frac{1}{2} (y - \frac{\tau}{Z}), $$ cures 1

and $U_f$ is this through a filter of first order with the time constant $T_f$ (`filter_time`). The top is to turn with
$r$: `speed_ref`, if `slip` is compensated; else less by the mean slip,

$$ r = r_{\text{asked}} - \frac{\tau_m}{c_a}, $$ cures 2

with the torque $\tau_m$ filtered by `slip_time`. A virtual drive of damping $P$, stiffness $K$ and inertia $J_v$ lags
behind $r$ by the speed $u$,

$$ J_v \frac{du}{dt} = Z (r - u - 2 U_f) - P u - K q, \qquad \frac{dq}{dt} = u, $$ cures 3

integrated by the trapezoidal rule, and the real drive is given the speed at which string and slip pass on the wave that
the virtual one would send:

$$ \Omega = \frac{(c_a + Z)(r - u - U_f) + (c_a - Z) U_f}{c_a}. $$ cures 4

So the string meets $P + K / s + J_v s$ at its top, where a stiff drive shows it $c_a$.
"""),
    ),
)

SWITCH: Sections = (
    (
        "On and off",
        paragraphs(r"""
While `enabled` is false, `speed_ref` passes through, and the law observes. At a switch, what the speed would jump by is
added to it and dies away:

$$ \Omega = \Omega_{\text{law}} + d, \qquad d(t + h) = e^{-h / T} d(t), $$ cures 6

with $T$ = `handover_time`. The start is such a switch: `Omega` begins at `speed_ref`. The speed is kept within

$$ -\Omega_{\text{max}} \le \Omega \le \Omega_{\text{max}}; $$ cures 7

as the law goes by the wave that really came, nothing winds up while the limit holds.
"""),
    ),
)

EQUATIONS: Sections = (
    *VIRTUAL_DRIVE,
    (
        "Gains by formula",
        paragraphs(r"""
The stick-slip frequency is the lowest root of $\tan(\omega \Gamma) = Z / (\omega I_B)$, $\Gamma$ being the time a wave
takes along the string. Then

$$ P = \frac{3}{2} Z, \qquad K = \frac{P \omega_s}{6}, \qquad J_v = 0 $$ cures 5

with `mode` soft_torque. With z_torque $P = Z$: every wave is absorbed but for what $K$ sends back. With own, `P`, `K`
and `J_v` are those given.
"""),
    ),
    *SWITCH,
    (
        "What delay it bears",
        paragraphs(r"""
Behind a delay $d$ of the drive, the reflection at the top is no more the $R$ that is meant but

$$ \Upsilon + (R - \Upsilon) F e^{-j \omega d}, $$ cures 8

$\Upsilon = (Z - c_a) / (Z + c_a)$ being that of the bare drive and $F = 1 / (1 + j \omega T_f)$. It must not exceed 1
in size at any frequency. With the start values $T_f \ge 2 d$ keeps to that for both modes by formula; a bare drive with
a greater $c_a$ needs more. A lag of the drive counts as a delay. `models.controllers.delay` computes the least $T_f$.
"""),
    ),
)

LIMITS = phrases(
    "Torque alone does not do: a law that softens the drive by the torque's deviations has a loop gain of 1 at $P = Z$ "
    "and diverges. Speed and torque are both needed, to tell the wave that comes from the one that was sent.",
    "The law must know `G`, `J`, `I` and `c_a` of the plant; $Z$ twice as assumed makes it another law.",
    "While weight is put on, a soft drive dips by about (torque per second) / `K`: 97 kN in 10 s make the bit stick at "
    "10 rad/s where a stiff drive does not. Put it on in 20 s, or enable the law afterwards.",
    "With compensated slip the string turns faster than with a stiff drive at the same `speed_ref`; that alone is a "
    "cure, and not to be compared with laws that leave the slip.",
)

USE = phrases(
    "Connect `top_speed` and `top_torque` from the string, `speed_ref` from DrillingProgram, and `Omega` to the "
    "string, or to TopDrive and from there to the string.",
    "The communication step is the law's sample time: 0.01 s will do.",
    "Set `filter_time` to twice the delay and lag of the drive, or more; 0.04 s are enough for 0.02 s.",
    "Watch `limit_active`: while it is true, `Omega` is not what the law asks for.",
)
