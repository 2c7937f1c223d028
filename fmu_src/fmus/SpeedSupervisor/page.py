"""Write the documentation page of SpeedSupervisor.

Labels "cures n" are numbers of docs/cures.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "Downhole",
        paragraphs(r"""
The severity of stick-slip over the last window $T_w$ (`window`) is the swing of the bit speed $v$ by twice its mean,
$v_m$,

$$ S = \frac{\max v - \min v}{2 v_m}, $$ cures 29

and `severity_max` where that is greater, or the bit does not turn forward. The window moves on by a fortieth of itself
at a time. Before the first is complete the severity is 0.
"""),
    ),
    (
        "At the top",
        paragraphs(r"""
What arrives of it is `measured`, $S_a$. At every multiple of $T_d$ (`interval`) the speed asked for is raised while
it is above the threshold $S_0$, by $r_s$ (`speed_step`),

$$ S_a > S_0: \qquad r_{k+1} = \min(r_k + r_s, r_{\text{max}}), \qquad r_0 = r_{\text{initial}}, $$ cures 30

if it is `valid` and the supervisor is `enabled`. The speed is never lowered.
"""),
    ),
)

LIMITS = phrases(
    "The meter and the driller are one FMU, with a link between them that is another: connect `severity` to `value` of "
    "MudPulse, and its `measured` and `valid` back. Without a link connect `severity` to `measured`.",
    "An FMU that interpolates its inputs sees what is between communication points; else the bit speed is held over a "
    "step, and a stop that is shorter than a step is missed.",
    "A step must not hold more than 10,000 fortieths of a window, or as many decisions.",
)

USE = phrases(
    "Connect `bit_speed` from the string, and `speed_ref` to a law, a drive or the string.",
    "Give `interval` the time of a window and of the link's delay, so that each decision sees what the last one did.",
)
