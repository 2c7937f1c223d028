"""The interface table of MudPulse: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import NOT_IN_THE_PAPER, choice_row, flag_row, output_row, parameter_row, telemetry_terminal
from ...schema import Model, Variable
from . import page


def _count(name: str, start: int, least: int, most: int, text: str) -> Variable:
    return Variable(
        name, "parameter", text, "Integer", "fixed", start=start, minimum=least, maximum=most, equation="cures 24"
    )


MODEL = Model(
    name="MudPulse",
    description="Telemetry from downhole: frames of bits that arrive late, coarse, and not all of them",
    variables=(
        Variable("value", "input", "What is measured downhole", unit="1", start=0.0, minimum=-1e9, maximum=1e9, nominal=20.0, equation="cures 23"),
        Variable(
            "measured", "output", "What has arrived last; value_min before that", variability="discrete", unit="1",
            equation="cures 23", initial_dependencies=("value_min",),
        ),
        output_row("age", "s", "Time since that was sampled; since the start before anything has arrived", "cures 25"),
        flag_row("valid", "Something has arrived, and the frame that was due last", "cures 25", (), ()),
        flag_row("limit_active", "What has arrived last is an end of the range", "cures 23", (), ()),
        choice_row("link", "10 bit/s through mud, 57,600 bit/s through wired pipe, or bit_rate and wave_speed", "cures 24", "mud_pulse", "wired_pipe", "own"),
        parameter_row("L", "m", 1172.0, 1.0, 1e5, "Length of the string", "cures 24"),
        parameter_row("value_min", "1", 0.0, -1e9, 1e9, f"Least value that is sent ({NOT_IN_THE_PAPER})", "cures 23"),
        parameter_row("range", "1", 40.0, 1e-9, 1e9, f"Range above it that is sent ({NOT_IN_THE_PAPER})", "cures 23"),
        parameter_row("sample_time", "s", 0.01, 0.0, 1e4, f"Least time between samples; not less than a frame ({NOT_IN_THE_PAPER})", "cures 24"),
        _count("bits", 8, 1, 24, f"Bits of a value ({NOT_IN_THE_PAPER})"),
        _count("overhead", 2, 0, 1000, f"Other bits of a frame ({NOT_IN_THE_PAPER})"),
        parameter_row("bit_rate", "1", 10.0, 1e-3, 1e9, f"Bits in a second; link own ({NOT_IN_THE_PAPER})", "cures 24"),
        parameter_row("wave_speed", "m/s", 1200.0, 1.0, 1e9, f"Speed of what carries them; link own ({NOT_IN_THE_PAPER})", "cures 24"),
        parameter_row("loss", "1", 0.0, 0.0, 1.0, "Probability that a frame is lost", "cures 25"),
        Variable("seed", "parameter", "Seed of the losses", "Integer", "fixed", start=1, minimum=1, maximum=2147483646, equation="cures 25"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(telemetry_terminal("value"),),
)  # fmt: skip
