"""The core of the console: the native FMU's bits, and nothing asked of its surroundings."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fmu_src.console import page
from models.parameters import DrillstringParameters
from models.theory import critical_omega
from tests.theory.strings import STRINGS
from tests.web.programs import PROGRAMS, as_json, bits, native

pytestmark = [pytest.mark.slow]
HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def in_node(node: str, console: Path) -> bytes:
    command = [node, HERE / "replay.mjs", console]
    return subprocess.run(command, input=as_json().encode(), capture_output=True, check=True).stdout


def test_every_output_has_the_bits_of_the_native_fmu_at_every_step(in_node: bytes) -> None:
    place = 0
    for name, program in PROGRAMS.items():
        expected = native(program)
        size = expected.size * 8
        found = np.frombuffer(in_node[place : place + size], "<f8").reshape(expected.shape)
        assert expected[:, 0].std() > 1.0, "nothing happens in it"
        different = np.flatnonzero((found.view("<i8") != expected.view("<i8")).any(axis=1))
        assert found.tobytes() == bits(expected), f"{name} differs from step {different[:1]} on"
        place += size
    assert place == len(in_node)


def test_it_imports_nothing(node: str, console: Path) -> None:
    code = "const core = require('fs').readFileSync(process.argv[1]);"
    code += "console.log(WebAssembly.Module.imports(new WebAssembly.Module(core)).length)"
    run = subprocess.run([node, "-e", code, console / "core.wasm"], capture_output=True, text=True, check=True)
    assert run.stdout == "0\n"


def test_the_torque_drawn_along_the_string_meets_its_ends_and_has_a_front(node: str, console: Path) -> None:
    travel_time = DrillstringParameters().travel_time
    command = [node, HERE / "waves.mjs", console, "0.2", "0.6", "1.0"]
    found = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    for each in found:  # the bit is held: what the rock bears is what the string brings
        assert each["stuck"] == 1.0
        assert each["torque"][0] == pytest.approx(each["top"], rel=1e-9)
        assert each["torque"][-1] == pytest.approx(each["bit"], rel=1e-9, abs=1e-9)
    first = np.array(found[0]["torque"])
    depth = np.linspace(0.0, 1.0, first.size)
    assert first[depth < 0.2 / travel_time - 0.03] == pytest.approx(first[0])
    assert first[depth > 0.2 / travel_time + 0.03] == pytest.approx(0.0, abs=1e-9)


def _critical(string: DrillstringParameters, weight: float) -> float | None:
    try:
        return critical_omega(string, weight)
    except ValueError:  # stable down to rest
        return None


def test_its_threshold_is_that_of_the_theory_for_other_strings_too(node: str, console: Path) -> None:
    cases = [(string, weight) for string in STRINGS.values() for weight in (3000.0, 31649.0, 97347.0, 200000.0)]
    expected = [_critical(*case) for case in cases]
    assert None in expected
    command = [node, HERE / "thresholds.mjs", console]
    text = json.dumps([(dataclasses.asdict(string), weight) for string, weight in cases])
    found = json.loads(subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout)
    assert [each is None for each in found] == [each is None for each in expected]
    assert [each for each in found if each] == pytest.approx([each for each in expected if each], rel=1e-9)


def test_gains_of_a_drive_that_is_not_there_change_no_verdict(node: str, console: Path) -> None:
    # just below the threshold of steady rotation a swing takes minutes to grow, and just above it to die away
    threshold = critical_omega(DrillstringParameters(), 97347.0)
    speeds = [str(threshold - 0.045), str(threshold + 0.055)]
    command = [node, HERE / "severities.mjs", console, *speeds]
    found = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    assert [each["sticks"] for each in found["plain"]] == [True, False]
    assert found["noisy"] == found["plain"]


def test_a_wheel_takes_the_page_if_it_is_made_from_these_sources(
    console: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "BUILT", tmp_path / "nothing built")
    assert not page.take_page(tmp_path / "none")
    built = tmp_path / "built"
    shutil.copytree(console, built)
    monkeypatch.setattr(page, "BUILT", built)
    assert page.take_page(tmp_path / "whole")
    assert (tmp_path / "whole" / page.PAGE).read_bytes() == (console / page.PAGE).read_bytes()
    text = (built / page.PAGE).read_text(encoding="utf-8")
    (built / page.PAGE).write_text(re.sub('made-from" content="..', 'made-from" content="00', text), encoding="utf-8")
    assert not page.take_page(tmp_path / "old")


def test_builds_in_two_folders_have_the_same_bytes(console: Path, tmp_path: Path) -> None:
    other = page.build_page(tmp_path / "an other place")
    assert other.read_bytes() == (console / page.PAGE).read_bytes()
