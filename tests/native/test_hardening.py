"""The C code of the FMUs under sanitizers: calls at random, lives of instances, allocations that fail, threads."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from fmu_src.fmus import MODELS
from tests.native.programs import ADDRESS, FUZZ, MEMORY, SEED, THREAD, Edit, Kind, compile_linked, run

pytestmark = pytest.mark.hardening

CALLS = int(os.environ.get("CALLS", "100000"))
FEWER = 10_000
PLANT, PROGRAM = "DrillstringNeutral", "DrillingProgram"


def random_calls(model: str, kind: Kind, calls: int, place: Path, seed: int = SEED) -> None:
    """Make calls at random; the program names the seed that breaks a law or touches foreign memory."""
    printed = run([compile_linked(model, kind), "random", seed, calls], place)
    assert int(re.findall(r"^(\d+) calls$", printed, re.MULTILINE)[-1]) >= calls


@pytest.mark.parametrize("model", MODELS)
def test_calls_at_random_break_no_law_and_touch_no_foreign_memory(model: str, tmp_path: Path) -> None:
    random_calls(model, ADDRESS, CALLS, tmp_path)


@pytest.mark.parametrize("model", MODELS)
def test_calls_written_down_break_no_law_and_touch_no_foreign_memory(model: str, tmp_path: Path) -> None:
    run([compile_linked(model, ADDRESS), "walks", "walks.txt"], tmp_path)


@pytest.mark.parametrize("model", [PLANT, PROGRAM])
def test_nothing_depends_on_memory_that_was_never_written(model: str, tmp_path: Path) -> None:
    random_calls(model, MEMORY, FEWER, tmp_path)


@pytest.mark.parametrize("model", MODELS)
def test_ten_thousand_lives_leave_no_memory_behind(model: str, tmp_path: Path) -> None:
    assert run([compile_linked(model, ADDRESS), "cycles", 10_000], tmp_path) == "10000 cycles\n"


@pytest.mark.parametrize("model", MODELS)
def test_any_allocation_may_fail(model: str, tmp_path: Path) -> None:
    printed = run([compile_linked(model, ADDRESS), "starve"], tmp_path)
    failed = re.fullmatch(r"(\d+) allocations have failed, each once\n", printed)
    assert failed is not None
    assert int(failed[1]) >= 8


@pytest.mark.parametrize("model", [PLANT, PROGRAM])
def test_instances_in_threads_do_not_meet(model: str, tmp_path: Path) -> None:
    assert run([compile_linked(model, THREAD), 4, SEED, FEWER // 4], tmp_path) == "4 threads\n"


def test_the_fuzz_target_runs(tmp_path: Path) -> None:
    run([compile_linked(PLANT, FUZZ), "-runs=300", f"-seed={SEED}", "-max_len=1024"], tmp_path)


DEFECTS = {
    "an instance is not freed whole": Edit(
        "fmi2.c", "        free(instance->name);\n", "", "LeakSanitizer|blocks are not freed"
    ),
    "a value is set before it is refused": Edit(
        "fmi2_values.c",
        "if (!in_range(instance",
        "assign(instance, vr[i], number_at(values, i, kind));\n        if (!in_range(instance",
        "left the instance alone",
    ),
    "a damaged state is taken": Edit(
        "fmi2_state.c",
        "head.checksum != checksum_of",
        "head.checksum == 0 * checksum_of",
        "DeSerializeFMUstate: status 0",
    ),
    "a state lacks the waves": Edit(
        "fmi2_state.c",
        "memcpy(saved + 1, instance->memory, instance->memory_size)",
        "memset(saved + 1, 0, instance->memory_size)",
        "repeated|AddressSanitizer|runtime error",
    ),
    "a ring is left": Edit("ds_line.c", "line->first = 0;", "", "AddressSanitizer|runtime error"),
    "a loss is counted twice": Edit("ds_bit.c", "bit->loss += ", "bit->loss += 2.0 * ", "J are unaccounted for"),
    "a refused step leaves its pieces": Edit(
        "ds_line.c",
        "ring[index] = ring[2 * line->capacity + index];",
        "(void)ring[index];",
        "left the instance alone",
    ),
    "a refusal is silent": Edit(
        "fmi2_instance.c",
        "status >= fmi2Error || instance->logging[category]",
        "status < fmi2Error",
        "without a message",
    ),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_defect_is_found(defect: str, tmp_path: Path) -> None:
    edit = DEFECTS[defect]
    kind = Kind(f"defect-{list(DEFECTS).index(defect)}", ADDRESS.compiler, ADDRESS.flags, edit=edit)
    with pytest.raises(AssertionError, match=edit.finding):
        random_calls(PLANT, kind, CALLS, tmp_path)
