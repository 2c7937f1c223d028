"""FMUs of dist/ and the bare kernel under loops in C, so that what is timed is what they cost and not Python."""

from __future__ import annotations

import ctypes
import re
import subprocess
import sys
from ctypes import c_double, c_int, c_long, c_size_t, c_uint, c_void_p
from functools import cache
from pathlib import Path

import fmpy

from fmu_src.build.header import table_header
from fmu_src.build.native import FLAGS, FMI_HEADERS, NATIVE
from fmu_src.build.source_code import source_code
from fmu_src.fmus import MODELS
from tests.plant.drive import Drive
from tests.plant.fmi import Instance

MOST = 64
PLANT = MODELS["DrillstringNeutral"]
# What is written for the FMI adapter is not the kernel.
_ADAPTER = re.compile(r'#include "ds_(model|plant)\.h"')
BUILD = Path(__file__).parents[2] / "build" / "bench"


class Importer(ctypes.Structure):
    """The struct `importer` of loop.c."""

    _fields_ = (
        ("component", c_void_p),
        *((name, c_void_p) for name in ("set_real", "do_step", "get_real", "get_integer", "get_boolean")),
        ("reals", c_size_t),
        ("integers", c_size_t),
        ("booleans", c_size_t),
        ("real", c_uint * MOST),
        ("integer", c_uint * MOST),
        ("boolean", c_uint * MOST),
        ("input", c_uint),
    )


@cache
def loops() -> ctypes.CDLL:
    """Compile loop.c with the kernel, as the FMUs are compiled, and load it."""
    BUILD.mkdir(parents=True, exist_ok=True)
    library = BUILD / f"loop{fmpy.sharedLibraryExtension}"
    (BUILD / "ds_table.h").write_text(table_header(PLANT, "{bench}"), encoding="utf-8")
    hand_written = [
        NATIVE / name for name in sorted(source_code(PLANT)) if name.startswith("ds_") and name.endswith(".c")
    ]
    kernel = [path for path in hand_written if path.is_file() and not _ADAPTER.search(path.read_text(encoding="utf-8"))]
    sources = [Path(__file__).with_name("loop.c"), *kernel]
    command = [sys.executable, "-m", "ziglang", "cc", *FLAGS, "-I", BUILD, "-I", NATIVE, "-I", FMI_HEADERS, *sources]
    subprocess.run([*map(str, command), "-lm", "-o", str(library)], check=True)
    loaded = ctypes.CDLL(str(library))
    loaded.bench_kernel.argtypes, loaded.bench_kernel.restype = (c_double, c_long, c_int), c_double
    loaded.bench_do_step.argtypes = (c_void_p, c_double, c_long)
    loaded.bench_fmu.argtypes = (c_void_p, c_double, c_long, c_int, c_int)
    loaded.bench_coupled.argtypes = (c_void_p, c_size_t, c_void_p, c_size_t, c_double, c_long)
    return loaded


def importer(fmu: Instance, input_name: str | None = None) -> Importer:
    """Bind the functions of an FMU, one input to set, if any, and all outputs to get."""
    outputs = [v for v in fmu.variables.values() if v.causality == "output"]
    groups = {kind: [v.valueReference for v in outputs if v.type == kind] for kind in ("Real", "Integer", "Boolean")}
    bound = Importer(component=fmu.component)
    if input_name is not None:
        bound.input = fmu.variables[input_name].valueReference
    for field, function in (
        ("set_real", "fmi2SetReal"),
        ("do_step", "fmi2DoStep"),
        ("get_real", "fmi2GetReal"),
        ("get_integer", "fmi2GetInteger"),
        ("get_boolean", "fmi2GetBoolean"),
    ):
        setattr(bound, field, ctypes.cast(fmu.library.functions[function], c_void_p))
    for kind, references in groups.items():
        setattr(bound, f"{kind.lower()}s", len(references))
        getattr(bound, kind.lower())[: len(references)] = references
    return bound


def run_kernel(step: float, end: float, cells: int = 0) -> float:
    """Run Fig. 2 by the bare kernel and return the last bit speed [rad/s]."""
    return loops().bench_kernel(step, round(end / step), cells)


def run_plant(step: float, end: float, *, cells: int = 0, jump: bool = False) -> float:
    """Run the plant FMU from rest, Omega set before every step, and return the last bit speed [rad/s]."""
    with Drive("DrillstringNeutral", {"cells": cells}) as plant:
        bound = importer(plant, "Omega")
        assert loops().bench_fmu(ctypes.byref(bound), step, round(end / step), 1, int(jump)) == 0
        return plant.named()["bit_speed"]


def run_do_step(step: float, end: float) -> None:
    """Run the plant FMU from rest with nothing set and nothing read."""
    with Drive("DrillstringNeutral", {}) as plant:
        assert loops().bench_do_step(ctypes.byref(importer(plant, "Omega")), step, round(end / step)) == 0
