"""What a run of the driver has loaded stays as it is while another process makes the same program anew."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmu_src.build.native import host_target
from tests.native import programs


def test_library_of_a_former_build_is_replaced_and_not_written_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(programs, "BUILD", tmp_path)
    monkeypatch.setattr(programs, "_compile", lambda command, program, inputs: program)
    target = host_target()
    path = programs.library("WeightOnBitLaw", target)
    path.parent.mkdir(parents=True)
    path.write_bytes(b"of a former build")
    with path.open("rb") as loaded:
        programs.compile_loaded("WeightOnBitLaw", target)
        assert loaded.read() == b"of a former build"
    found = path.stat()
    assert found.st_size > 1000
    programs.compile_loaded("WeightOnBitLaw", target)
    again = path.stat()
    assert (again.st_ino, again.st_mtime_ns) == (found.st_ino, found.st_mtime_ns), "the same bytes were written again"
