"""Write a law of one's own to begin with: one Python file that becomes an FMU, and a scenario that it acts in."""

from __future__ import annotations

import keyword
import re
from pathlib import Path

from cosim.errors import InputError, OutputError

_LAW = '''\
"""@NAME@: a law of the drive's speed. It sends no wave back down the string."""

from fmu_src.python.switched_law import SwitchedLaw
from fmu_src.rows import drive_law, parameter_row

T_F, T_M = 0.04, 5.0  # time constants of the filters of wave and mean torque [s]
MODEL = drive_law(  # with top_speed, top_torque, speed_ref, enabled; Omega, limit_active
    "@NAME@",
    "Drive speed that sends no wave back down the string",
    parameter_row("Z", "N.m.s/rad", 299.3, 1.0, 1e6, "Wave impedance of the string"),
    parameter_row("c_a", "N.m.s/rad", 2000.0, 1.0, 1e9, "Slip: torque / (Omega - top_speed)"),
)


class @NAME@(SwitchedLaw):
    model = MODEL

    def remember(self, values):  # what is kept in mind, at the start: the wave that comes up, and the mean torque
        speed, torque, Z = (values[self.at[name]] for name in ("top_speed", "top_torque", "Z"))
        return (speed - torque / Z) / 2.0, torque

    def go_on(self, own, values, elapsed):  # the same after a step of `elapsed` seconds: both follow through filters
        shares = (elapsed / (T + elapsed) for T in (T_F, T_M))
        return tuple(was + share * (now - was) for was, now, share in zip(own, self.remember(values), shares))

    def ask(self, own, values):  # Omega while enabled: the wave sent down is that of steady rotation, whatever comes up
        speed, Z, c_a = (values[self.at[name]] for name in ("speed_ref", "Z", "c_a"))
        down = (speed - own[1] / c_a + own[1] / Z) / 2.0
        return (1.0 + Z / c_a) * down + (1.0 - Z / c_a) * own[0]
'''

_SCENARIO = """\
title = "@NAME@, switched on in full stick-slip"
stop_time = 120.0
step_size = 0.01
algorithm = "gauss-seidel"

connections = [
    { from = "plant.top_speed", to = "law.top_speed" },
    { from = "plant.top_torque", to = "law.top_torque" },
    { from = "law.Omega", to = "drive.Omega_command" },
    { from = "plant.top_torque", to = "drive.top_torque" },
    { from = "drive.Omega", to = "plant.Omega" },
]

[components.drive]
fmu = "TopDrive"

[components.plant]
fmu = "DrillstringNeutral"

[components.law]
fmu = "@NAME@.fmu"

[inputs]
"plant.WOB" = 97347.0
"law.speed_ref" = 10.0
"law.enabled" = { kind = "step", before = false, after = true, at = 40.0 }

[[variants]]
name = "on"

[[variants]]
name = "off"
set = { "law.enabled" = false }

[figure]
signals = ["plant.bit_speed", "plant.top_speed", "law.Omega"]
"""
_TAKEN = ("MODEL", "SwitchedLaw", "T_F", "T_M", "drive_law", "parameter_row")
"""Names that the file uses for something else."""
_RESERVED = re.compile(r"CON|PRN|AUX|NUL|(COM|LPT)\d", re.IGNORECASE)
"""Names that no file can have under Windows."""
_LONGEST = 64


def write_law(name: str, folder: Path, known: list[str]) -> list[Path]:
    """Write a law and its scenario to a folder, which is made; return the paths.

    Parameters
    ----------
    name : str
        Of the law.
    folder : Path
        Must be new or empty.
    known : list of str
        Names of the FMUs that there are.

    Raises
    ------
    InputError
        If the name does not do, or the folder holds something; nothing is written.
    OutputError
        If the folder cannot be written.
    """
    fits = re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) and len(name) <= _LONGEST and not keyword.iskeyword(name)
    if not fits or _RESERVED.fullmatch(name) or name in _TAKEN:
        raise InputError(
            f"'{name}' is no name for a law; expected at most {_LONGEST} letters, digits and _, a letter first, and no "
            "word of Python, of the file or of Windows"
        )
    if name.lower() in (each.lower() for each in known):
        raise InputError(f"there is an FMU {name} already; expected another name")
    texts = {folder / f"{name}.py": _LAW, folder / f"{name}.toml": _SCENARIO}
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise InputError(f"{folder} is there already; expected a folder that is new or empty")
        folder.mkdir(parents=True, exist_ok=True)
        for path, text in texts.items():
            with path.open("x", encoding="utf-8", newline="\n") as file:
                file.write(text.replace("@NAME@", name))
    except OSError as error:
        raise OutputError(f"folder {folder} cannot be written: {error.strerror or error}") from error
    return list(texts)
