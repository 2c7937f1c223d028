"""Damage to the folders of runs, finished or interrupted: it is named, or no number is another one for it."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import pytest

from tests.cosim.run.damage import KINDS, attacked

pytestmark = [
    pytest.mark.hardening,
    pytest.mark.skipif(sys.platform == "win32", reason="links and pipes are for those who administer the machine"),
]


@pytest.mark.parametrize("seed", range(4))
def test_damage_of_a_folder_is_named_or_harmless(seed: int) -> None:
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None) as folder:
        counts, wrong = attacked(250, seed, Path(folder))
    assert not wrong, "\n".join(wrong)
    assert counts.total() == 250
    assert sum(counts[f"{kind}: named"] for kind in KINDS) > 150, "most of the bytes matter"
