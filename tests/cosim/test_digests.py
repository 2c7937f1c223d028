"""The digest of a file is that of what is in it now, and is worked out once while nothing changes it."""

from __future__ import annotations

import hashlib
import os
import time
from pathlib import Path

import pytest

from cosim.files import digest_of


def digest(path: Path) -> tuple[bytes, bool]:
    """Return the digest of a file, and whether it was read for it."""
    with path.open("rb") as file:
        return digest_of(file), file.tell() > 0


@pytest.mark.parametrize("later", [0, 10_000_000_000])
def test_a_file_that_is_changed_has_another_digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, later: int) -> None:
    clock = time.time_ns
    monkeypatch.setattr(time, "time_ns", lambda: clock() + later)
    path = tmp_path / "model.fmu"
    for content in (b"one", b"two", b"one"):
        time.sleep(0.02)  # two clock ticks of any kernel: what guards against one is not used here, but for `later` 0
        path.write_bytes(content)
        os.utime(path, ns=(10**18, 10**18))  # as unpacking does
        for again in (False, True):
            found, was_read = digest(path)
            assert found == hashlib.sha256(content).digest()
            assert was_read == (not again or later == 0)  # a time that has just been may come again


def test_a_file_in_the_place_of_another_has_its_own_digest(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"one")
    (tmp_path / "b").write_bytes(b"two")
    digest(tmp_path / "a")
    os.replace(tmp_path / "b", tmp_path / "a")
    assert digest(tmp_path / "a")[0] == hashlib.sha256(b"two").digest()
