"""Write the documentation page of Autodriller.

Labels "cures n" are numbers of docs/cures.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "Weight and depth",
        paragraphs(r"""
The string is a spring that the feed $f$ at its top compresses and the bit relieves as it drills:

$$ \frac{dW}{dt} = k (f - R), $$ cures 26

with the rate of penetration $R$ (`rop`), whose integral is `depth`,

$$ R = a \max(W - W_0, 0) \max(v, 0). $$ cures 27

At a bit speed $v$ the weight follows the feed with the time constant $1 / (k a v)$: 55.6 s at 6.2 rad/s.
"""),
    ),
    (
        "The driller",
        paragraphs(r"""
With the error $e$ of the weight against `WOB_ref`,

$$ f = K_p (e + \frac{1}{T_i} \int e \, dt), \qquad f_{\text{min}} \le f \le f_{\text{max}},
\qquad 0 \le W \le W_{\text{max}}. $$ cures 28

The feed is chosen at the beginning of a step and held, so that the step is the driller's sample time. While a limit
holds, what would drive the feed further is not added up. While `enabled` is false the feed stays as it is, and the
controller goes on from there when it is switched on.
"""),
    ),
)

LIMITS = phrases(
    "The weight is that of a string without mass: axial waves, of a few tenths of a second, are left out.",
    "With `feed_min` at 0 the string is never lifted, and only a bit that turns takes weight off: one that has stalled "
    "under more than the drive can turn, as where it was fed on while `enabled` was false, stays so. With less than 0 "
    "the driller lifts it off.",
    "`WOB_initial` may be greater than `WOB_max`; the first step brings it down.",
)

USE = phrases(
    "Connect `bit_speed` from the string and `WOB` to the string. Steps of 0.01 s as for the string will do; up to "
    "some seconds the driller is as good.",
    "With stick-slip the mean of the bit speed falls, and the rate of penetration with it: docs/cures.md has figures.",
)
