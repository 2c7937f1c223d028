"""Write the documentation page of TopAbsorber.

Labels "cures n" are numbers of docs/cures.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases
from ..SoftTorque.page import SWITCH, VIRTUAL_DRIVE

EQUATIONS: Sections = (
    *VIRTUAL_DRIVE,
    (
        "The table",
        paragraphs(r"""
The virtual drive is a table of inertia $J_a$ that spring and damper hold to the rotation asked for (Jansen and van
den Steen): $P = c_f$, $K = k_f$, $J_v = J_a$. With `mode` tuned,

$$ c_f = \frac{3}{2} Z, \qquad J_a = \frac{c_f}{4 \omega_s}, \qquad k_f = J_a \omega_s^2, $$ cures 18

the table resonates at the stick-slip frequency, the lowest root of $\tan(\omega \Gamma) = Z / (\omega I_B)$, and
shows the string its damper alone there.
"""),
    ),
    *SWITCH,
)

LIMITS = phrases(
    "A mass hung on the top, by spring and damper, does not help: with a stiff drive the top is next to a node of "
    "the oscillation, and what does not move cannot take up energy. It is the drive itself that must give way.",
    "The law must know `G`, `J`, `I` and `c_a` of the plant.",
    "A table gives way to changes of the torque as a soft drive does: put weight on slowly.",
)

USE = phrases(
    "As SoftTorque: connect `top_speed` and `top_torque` from the string, `speed_ref` from DrillingProgram, and "
    "`Omega` to the string, or to TopDrive and from there to the string. The communication step is the law's sample "
    "time: 0.01 s will do.",
    "It takes longer than SoftTorque to come to rest, and a longer filter behind the same drive: set `filter_time` "
    "to 2.25 times its delay and lag, or more, but not to 0.2 s.",
)
