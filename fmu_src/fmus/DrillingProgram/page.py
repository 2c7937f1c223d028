"""Write the documentation page of DrillingProgram.

Labels "Eq. (n)" are numbers of the paper, "model n" those of docs/model.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "One change of each",
        paragraphs(r"""
Rotation and weight each go on a straight line from $a$ (`_initial`) to $b$ (`_final`), beginning at $t_0$ (`_start`)
and taking $d$ (`_duration`); a duration of 0 is a step.

$$ x(t) = a + (b - a) \, \min(\max(\frac{t - t_0}{d}, 0), 1) $$ model 21
"""),
    ),
    (
        "Or a table",
        paragraphs(r"""
`table` is the path of a CSV file that replaces both changes. Its first line is `time,speed,WOB`; then one row a point,
in s, rad/s and N. Values follow straight lines between rows, and jump where two rows share a time; the first row holds
before it, the last row after it.
"""),
    ),
    (
        "Outputs",
        paragraphs(r"""
`Omega`, `speed_ref` and `bit_speed_ref` are the rotation, under the names by which drives and laws know it; `WOB` is
the weight. `bit_torque_ref` is the torque on bit at that rotation $v$ and weight $W$:

$$ T(v) = c_b v + W R_b (\mu_{cb} + (\mu_{sb} - \mu_{cb}) e^{-(\gamma_b / v_f) |v|}) \sgn \, v $$ Eq. (3), (4)
"""),
    ),
)

LIMITS = phrases(
    "Outputs are known at communication points: a jump between two of them is seen at the second. A change within "
    "1e-9 max(1, |t|) s of a point counts as being there, so that rounding in the importer cannot put it off by a "
    "step.",
    "The table is read during initialisation, which a file that is missing or not understood refuses with "
    "fmi2Discard. The path is that of the importer's machine, 1023 bytes at most.",
    "The friction parameters must be those of the plant.",
)

USE = phrases(
    "Without a law, connect `Omega` and `WOB` to the string. With DissipativeLaw, connect `bit_speed_ref` and "
    "`bit_torque_ref` to it in place of `Omega`; with WeightOnBitLaw, leave out `WOB`.",
    "Nothing set, it asks for 10 rad/s and 97347 N from the start.",
    "Choose communication points that hit the jumps, or steps short enough for them. An importer that takes output "
    "derivatives (order 1) and hands them on as input derivatives has ramps exactly, however long the step.",
)
