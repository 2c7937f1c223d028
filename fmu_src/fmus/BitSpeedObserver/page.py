"""Write the documentation page of BitSpeedObserver.

Labels "cures n" are numbers of docs/cures.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "What the top tells of the bit",
        paragraphs(r"""
With speed $y$ and torque $\tau$ at the top, the impedance $Z = \sqrt{I G J}$ and the travel time $\Gamma = L \sqrt{I
/ (G J)}$, the wave that comes up now and the one that was sent down $2 \Gamma$ ago met at the bit $\Gamma$ ago:

$$ v(t - \Gamma) = \frac{1}{2} (y(t) - \frac{\tau(t)}{Z}) + \frac{1}{2} (y(t - 2 \Gamma)
+ \frac{\tau(t - 2 \Gamma)}{Z}), $$ cures 19

$$ T_s(t - \Gamma) = \frac{Z}{2} (y(t - 2 \Gamma) + \frac{\tau(t - 2 \Gamma)}{Z} - y(t)
+ \frac{\tau(t)}{Z}). $$ cures 20

Both are exact for a string without damping. The torque on bit takes the derivative of the speed, which is filtered
with $T_f$ (`filter_time`), as is the torque of the string:

$$ T = T_{s f} - I_B \frac{v - v_f}{T_f}. $$ cures 21

Between samples the wave sent down is on straight lines. The inputs are those at the end of a step.
"""),
    ),
    (
        "What is known",
        paragraphs(r"""
`valid` is true when

$$ t - t_0 \ge 2 \Gamma $$ cures 22

and neither wave has a jump there: a change in a step that is greater than `jump` and more than four times that of the
step before. Until then the outputs are those of a rotation that has always been as at the start.
"""),
    ),
)

LIMITS = phrases(
    "It is as good as what it knows of the string: `L`, `G`, `J` and `I`. docs/cures.md has the errors that follow "
    "from wrong ones, from noise and from damping along the string.",
    r"Up to a thousand samples in $2 \Gamma$ are kept; more than that are thinned. Steps that divide $2 \Gamma$ "
    "need no interpolation.",
    "All outputs are a travel time late.",
)

USE = phrases(
    "Connect `top_speed` and `top_torque` from the string, or what the sensors of TopDrive show.",
    "With noisy sensors, set `jump` to some ten times the noise of a wave, so that `valid` speaks of jumps alone.",
)
