"""What the documentation page inside each FMU says of its use: first steps, what to mind, how to compile it.

docs/import.md says more, tool by tool; the numbers are those of docs/model.md.
"""

from __future__ import annotations

from ..schema import Model
from .prose import paragraphs, phrase

_LOOP = (
    "The string answers at once: `top_speed` and `top_torque` answer `Omega`, and `bit_torque` answers `WOB`. A law "
    "that computes one from the other closes an algebraic loop. Co-simulation masters open it by one communication "
    "step, so the step is the law's sample time: take 0.001 s. A tool that refuses the loop wants a unit delay in the "
    "connection of `Omega`."
)

PLANT_USE: tuple[str, ...] = tuple(
    phrase(item)
    for item in (
        "Run it alone, with nothing connected and nothing set, from 0 to 100 s in steps of 0.01 s: this is the "
        "stick-slip cycle of the paper's Fig. 2. The bit first breaks loose at 2.603019251 s (`last_release_time`) and "
        "first stops at 4.226441632 s (`last_stop_time`). At the end the period is 3.2256227 s, the greatest "
        "`bit_speed_max` 18.7605 rad/s. If these come out, the import is right.",
        "Drive `Omega` and `WOB`, or connect the FMU DrillingProgram. Everywhere equal names fit.",
        "As long as inputs are held, the result does not depend on the communication step: 0.01 s is a good one, any "
        "other will do, constant or not. For what happens within a long step there are `bit_speed_min`, "
        "`bit_speed_max`, `slip_count`, `stuck_time`, `last_stop_time` and `last_release_time`.",
        _LOOP,
        "To begin in steady drilling, set `initial_speed`, `initial_torque` and `Omega` as told under "
        "“Before the start”.",
        "The paper's law for the drive speed is the FMU DissipativeLaw. As printed, (9) cannot hold a drilling speed; "
        "its tracking form can. The page of that FMU says why.",
    )
)

DISSIPATIVE_LAW_VERDICT = paragraphs(r"""
**As printed, law (9) cannot hold a drilling speed.** With dry friction it drains the energy for as long as the bit
turns, so there is no equilibrium in which the bit turns. At rest, law and string together have no solution at all, for
any $c_1$, $c_2$ and reference. Sampled, the law chatters through its pole at top speed 0, and what the bit then does is
made by `Omega_max` and the step size: every millisecond and with the limit of 40 rad/s it hovers round 10 rad/s, which
looks like success and is an accident. With 100 rad/s it hovers round 15 rad/s; behind a drive with 5 ms of lag the
string stops.

Set `form` to tracking (2) to drill. It is the same completion of the square, in deviations from the wanted rotation.
""")

DISSIPATIVE_LAW_USE: tuple[str, ...] = tuple(
    phrase(item)
    for item in (
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
)

WEIGHT_ON_BIT_LAW_USE: tuple[str, ...] = tuple(
    phrase(item)
    for item in (
        "Connect `bit_speed` from the string, and `WOB` to the string.",
        "The communication step is the law's sample time: 0.01 s will do, 0.001 s is closer to a law without one.",
        "The weight grows with the speed, so the string turns slower than with `WOB_0` alone: with the start values of "
        "all FMUs it settles at 5.179327 rad/s.",
    )
)

DRILLING_PROGRAM_USE: tuple[str, ...] = tuple(
    phrase(item)
    for item in (
        "Without a law, connect `Omega` and `WOB` to the string. With DissipativeLaw, connect `bit_speed_ref` and "
        "`bit_torque_ref` to it in place of `Omega`; with WeightOnBitLaw, leave out `WOB`.",
        "Nothing set, it asks for 10 rad/s and 97347 N from the start.",
        "Choose communication points that hit the jumps, or steps short enough for them. An importer that takes output "
        "derivatives (order 1) and hands them on as input derivatives has ramps exactly, however long the step.",
    )
)


def compiling(model: Model) -> str:
    """Return how to compile the sources of a native FMU, and what makes the result the same to the last bit, as HTML.

    FMI 2.0.4, section 2.3, wants this in the documentation.
    """
    return paragraphs(f"""
`sources/{model.name}.c` is the one file to compile, as C99; it includes the others. The FMI headers are not in the FMU:
they are the importer's. FMPy brings its own:

`fmpy compile {model.name}.fmu`

or, with a folder HEADERS that holds `fmi2Functions.h`, `fmi2FunctionTypes.h` and `fmi2TypesPlatform.h`,

`cc -std=c99 -O2 -fPIC -shared -DFMI2_OVERRIDE_FUNCTION_PREFIX -I HEADERS sources/{model.name}.c -lm -o {model.name}.so`

Linked into a program instead, without that definition, the functions have the prefix `{model.name}_`, and no other name
is visible, so several FMUs can be linked together.

Any compiler whose double precision is that of IEEE 754, without excess precision, gives the bits of the libraries in
this FMU. Fusing products with sums is switched off in `ds_arithmetic.h`; `-ffast-math` is refused. On x86 with 32 bits
add `-msse2 -mfpmath=sse`. GCC and Clang have been tried, MSVC has not.
""")
