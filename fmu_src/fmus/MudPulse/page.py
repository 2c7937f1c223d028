"""Write the documentation page of MudPulse.

Labels "cures n" are numbers of docs/cures.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "Frames",
        paragraphs(r"""
The range from $x_{\text{min}}$ (`value_min`) on is divided into $2^b - 1$ quanta, $b$ being `bits`; a value is
rounded to the nearest and kept within the range,

$$ x_q = x_{\text{min}} + \frac{R}{2^b - 1} n, \qquad 0 \le n \le 2^b - 1. $$ cures 23

A frame is those bits and `overhead`. Values are sampled at $k T_s$, the first at the start, where $T_s$ is
`sample_time` or the time that a frame takes, whichever is longer. One that is sampled arrives after frame and
transport,

$$ T = \frac{b + b_o}{f} + \frac{L}{c}, $$ cures 24

with 10 bit/s and 1200 m/s for `link` mud_pulse, 57,600 bit/s and no transport for wired_pipe, `bit_rate` and
`wave_speed` for own.
"""),
    ),
    (
        "Age and loss",
        paragraphs(r"""
A frame is lost with the probability $p$ (`loss`), by the generator that TopDrive has too, which begins at `seed`; the
value before it then goes on to be shown, and `valid` is false until the next arrives. `age` is the time since the
value was sampled:

$$ T \le t_a \le T + T_s $$ cures 25

while nothing is lost.
"""),
    ),
)

LIMITS = phrases(
    "With the start values a value is 2 to 3 s old, in a stick-slip cycle of 3.2 s. That is useless in a fast loop, "
    "of the weight or of the speed; it is good for set points.",
    "`value` is a number without a unit. A master that compares units refuses an output with one: give it a number.",
    "At most 254 frames are under way at a time, and a step must not hold more than a million.",
)

USE = phrases(
    "Connect anything to `value`, with `value_min` and `range` in its unit, and `measured` to what supervises the "
    "drilling.",
    "To send something slow about something fast, such as the severity of stick-slip over 20 s, compute it downhole,"
    " ahead of the link.",
)
