"""Verdicts that are the same on any processor: the short ones, with the kernels that others would take.

OpenBLAS and NumPy choose kernels by what the processor can do, and a sum of products differs between them in its last
bit. Each can be told to do as on another.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__  # pyright: ignore

# Of these names NumPy's releases have different ones (AVX2, FMA3, AVX512F; X86_V3, X86_V4), and it refuses any that it
# was not built with and warns of those the processor lacks.
BEYOND_BASELINE = " ".join(name for name in __cpu_dispatch__ if __cpu_features__[name])
SETTINGS = {
    **{name: {"OPENBLAS_CORETYPE": name} for name in ("Haswell", "SkylakeX", "Prescott", "Zen")},
    "NumPy's baseline": {"NPY_DISABLE_CPU_FEATURES": BEYOND_BASELINE},
}
VERDICTS = (
    "tests/plant/test_oracle_agreement.py::test_range_of_bit_speed_between_communication_points_is_the_oracles"
    "[inputs that jump on no grid]",
    "tests/oracle/test_oracle.py::test_bit_rests_on_where_a_falling_torque_touches_the_static_one_to_rounding",
    "tests/oracle/test_oracle.py::test_departure_that_is_over_within_the_rounding_of_an_instant_is_none",
    "tests/oracle/test_oracle.py::test_slip_much_shorter_than_a_piece_is_as_long_as_by_hand",
    "tests/theory/test_equilibria.py",
)


@pytest.mark.slow
@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="names kernels of x86 processors")
@pytest.mark.parametrize("setting", SETTINGS)
def test_short_verdicts_are_those_of_any_processor(setting: str) -> None:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **SETTINGS[setting]}
    environment.pop("PYTEST_ADDOPTS", None)
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", *VERDICTS]
    root = Path(__file__).parents[2]
    done = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
