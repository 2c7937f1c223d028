"""Write the documentation page of WeightOnBitLaw.

Labels "Eq. (n)" are numbers of the paper, "model n" those of docs/model.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "Weight on bit",
        paragraphs(r"""
With the bit speed $v$,

$$ W = K_w |v| + W_0, $$ Eq. (22)

$$ W \le W_{\text{max}}. $$ model 20
"""),
    ),
)

LIMITS = phrases(
    "The paper gives neither a value of `K_w` nor an upper limit; both start values are this project's own.",
    "`WOB_max` less than `WOB_0` is refused with fmi2Discard: by fmi2ExitInitializationMode, or by the next step.",
)

USE = phrases(
    "Connect `bit_speed` from the string, and `WOB` to the string.",
    "The communication step is the law's sample time: 0.01 s will do, 0.001 s is closer to a law without one.",
    "The weight grows with the speed, so the string turns slower than with `WOB_0` alone: with the start values of "
    "all FMUs it settles at 5.179327 rad/s.",
)
