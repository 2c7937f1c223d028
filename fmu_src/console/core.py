"""The C core for the browser: the models of the console in one WebAssembly module, and their interface tables."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from math import isfinite
from pathlib import Path
from typing import Any

from ..build.header import table_header
from ..build.native import compiler_environment
from ..build.source_code import TABLE_HEADER, source_code
from ..errors import BuildError
from ..fmus import MODELS
from ..rows import NOT_IN_THE_PAPER
from ..schema import Model, Variable

CONSOLE_MODELS = (
    "DrillstringNeutral",
    "DissipativeLaw",
    "WeightOnBitLaw",
    "SoftTorque",
    "TopAbsorber",
    "SpeedPid",
    "TopDrive",
    "SpeedSupervisor",
    "MudPulse",
    "BitSpeedObserver",
    "Autodriller",
)
"""What the console runs: the plant, the laws that act on it, and what may stand between them."""

# "...; mode own", "...; modes speed and servo": a parameter counts with some items of a choice alone.
_COUNTS = re.compile(r"; (?P<by>mode|link)s? (?P<items>\w+(?: and \w+)*)$")
_FUNCTIONS = ("allocate", "release", "start", "step", "reason")
_OURS = Path(__file__).with_name("core.c")
_TARGET = "wasm32-wasi"

# Those of the native FMUs that have to do with numbers, so that the bits are theirs; a reactor has no main.
_FLAGS = (
    *("-std=c99", "-O2", "-ffp-contract=off", "-fno-slp-vectorize", "-fno-math-errno", "-g0", "-s"),
    *("-fvisibility=hidden", "-ffunction-sections", "-fdata-sections", "-Wall", "-Wextra", "-Wconversion", "-Werror"),
    *("-mexec-model=reactor", "-Wl,--gc-sections"),
)


def compile_core() -> bytes:
    """Return the WebAssembly module with the models of the console.

    Raises
    ------
    BuildError
        With the compiler's messages.
    """
    with tempfile.TemporaryDirectory(prefix="drillstring-") as folder:
        stage = Path(folder)
        sources = [_lay_out(stage, MODELS[name]) for name in CONSOLE_MODELS]
        exports = [f"-Wl,--export={name}_{function}" for name in CONSOLE_MODELS for function in _FUNCTIONS]
        flags = ["-target", _TARGET, *_FLAGS, *exports]
        command = [sys.executable, "-m", "ziglang", "cc", *flags, *sources, "-o", "core.wasm"]
        run = subprocess.run(
            command,
            cwd=stage,
            env=compiler_environment(),
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        if run.returncode != 0 or not (stage / "core.wasm").is_file():
            messages = (run.stderr or run.stdout).strip() or f"zig ended with exit code {run.returncode} and no message"
            raise BuildError(f"the core of the console does not compile for {_TARGET}:\n{messages}")
        return (stage / "core.wasm").read_bytes()


def core_tables() -> dict[str, dict[str, dict[str, Any]]]:
    """Return for each model, by the names of its variables, what the page has to know of them.

    That is the value reference and the start value, the least and the greatest value where they are finite, and of
    parameters what it takes to ask for them: a text, the unit, the items of a choice, whether it is a whole number, can
    be set during a run, and by which choice it counts at all.
    """
    return {
        name: {variable.name: _row(reference, variable) for reference, variable in enumerate(MODELS[name].variables)}
        for name in CONSOLE_MODELS
    }


def _row(reference: int, variable: Variable) -> dict[str, Any]:
    low, high = variable.bounds
    row: dict[str, Any] = {"reference": reference}
    row["start"] = float(variable.start) if isinstance(variable.start, int | float) else 0.0
    if isfinite(low) and isfinite(high):
        row |= {"low": low, "high": high}
    return row | _asked(variable) if variable.causality == "parameter" else row


def _asked(variable: Variable) -> dict[str, Any]:
    """Return what is shown where a parameter can be set; its description tells with which mode it counts."""
    text = variable.description.removesuffix(f" ({NOT_IN_THE_PAPER})")
    asked: dict[str, Any] = {"text": text, "unit": variable.unit or ""}
    counts = _COUNTS.search(text)
    if counts is not None:
        asked |= {"text": text[: counts.start()], "by": counts["by"], "with": counts["items"].split(" and ")}
    if variable.items:
        asked["items"] = variable.items
    if variable.kind == "Integer":
        asked["whole"] = True
    if variable.variability == "tunable":
        asked["tunable"] = True
    return asked


def _lay_out(stage: Path, model: Model) -> str:
    """Write the sources of a model to a folder of its own; return the path of the file to compile."""
    folder = stage / model.name
    folder.mkdir()
    files = source_code(model) | {TABLE_HEADER: table_header(model, "").encode()}
    parts = sorted(name for name in files if name.endswith(".c") and not name.startswith(("fmi2", model.name)))
    whole = "\n".join(f'#include "{name}"' for name in ("ds_arithmetic.h", *parts, "core.c"))
    for name, content in files.items():
        (folder / name).write_bytes(content)
    (folder / "core.c").write_bytes(_OURS.read_bytes())
    (folder / "whole.c").write_text(
        f"#define DS_ONE_FILE\n#define DS_EXPORTED(function) {model.name}_##function\n{whole}\n", encoding="utf-8"
    )
    return f"{model.name}/whole.c"
