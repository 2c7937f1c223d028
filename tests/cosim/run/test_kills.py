"""Runs that are killed: what they end with, gone on with, is what they would have ended with."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]

pytestmark = [
    pytest.mark.hardening,
    pytest.mark.skipif(sys.platform == "win32", reason="processes are not forked there"),
]


def test_runs_killed_at_random_moments_end_as_others_do() -> None:
    command = [sys.executable, "-m", "tests.cosim.run.killing", "40", "1"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"^4\d kills of \d+ runs, 0 wrong$", done.stdout, re.M)
